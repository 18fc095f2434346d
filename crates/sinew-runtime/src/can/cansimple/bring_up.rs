//! An axis before it takes commands: found, compared, set up, its watchdog seen at work.

use super::parameters::{Endpoints, Parameter};
use super::slot::CansimpleSlot;
use super::{
    CLEAR_ERRORS, CLOSED_LOOP, GET_ENCODER_ESTIMATES, GET_ERROR, GET_VERSION, HEARTBEAT, HEARTBEAT_MS, IDLE,
    RX_SDO, SET_CONTROLLER_MODE, SET_LIMITS, TX_SDO, WATCHDOG_EXPIRED, ask, command, error_names, floats,
    pair, set_axis_state, set_input_vel, state_name, tell, words,
};
use crate::can::Link;
use crate::can::device::CanDevice;
use crate::can::error::CanError;
use crate::can::slot::Slot;
use crate::can::talk::{SILENCE, STATE_TIME, Talk};
use sinew::machine::Machine;
use sinew_segment::CanFrame as Frame;

/// Time for which heartbeats are counted, ns, and the part of those expected that come.
const COUNT_TIME: u64 = 200_000_000;
const COUNTED: f64 = 0.7;
/// Control mode and input mode: velocity, as it comes.
const VELOCITY: [u32; 2] = [2, 1];
/// Limit of the velocity over the motor's highest.
const HEADROOM: f64 = 1.1;
/// Finds an axis, sets it up for a machine and sees its watchdog take its power. Nothing moves: it has power
/// for that time, at a velocity of 0.
pub(in crate::can) fn start<L: Link>(
    link: &mut L,
    device: &CanDevice,
    machine: &Machine,
) -> Result<Box<dyn Slot>, CanError> {
    let mut axis = Axis { talk: Talk { link, device, period: machine.period_ns() } };
    let version = axis.identify()?;
    let parameters = machine.muscles[device.drive.muscle].drive;
    let (node, motor) = (device.node, parameters.motor);
    let limits = [HEADROOM * motor.top_speed / core::f64::consts::TAU, motor.peak_current];
    if let Some(path) = &device.endpoints {
        let endpoints = Endpoints::read(path).map_err(|problem| device.wrong(problem))?;
        if endpoints.firmware != version {
            let of = &endpoints.firmware;
            return Err(device.wrong(format!("firmware {version}: expected {of}, that of {path}")));
        }
        axis.set(&endpoints, "axis0.config.can.heartbeat_msg_rate_ms", f64::from(HEARTBEAT_MS))?;
        axis.set(&endpoints, "axis0.config.watchdog_timeout", machine.watchdog())?;
        axis.set(&endpoints, "axis0.config.enable_watchdog", 1.0)?;
        axis.set(&endpoints, "axis0.controller.config.control_mode", f64::from(VELOCITY[0]))?;
        axis.set(&endpoints, "axis0.controller.config.input_mode", f64::from(VELOCITY[1]))?;
        axis.set(&endpoints, "axis0.controller.config.vel_limit", limits[0])?;
        axis.set(&endpoints, "axis0.config.motor.current_soft_max", limits[1])?;
    }
    axis.count_heartbeats()?;
    let limits = limits.map(|limit| (limit as f32).to_bits());
    axis.talk.send(&[
        set_axis_state(node, IDLE),
        tell(node, CLEAR_ERRORS, &[0]),
        tell(node, SET_CONTROLLER_MODE, &pair(VELOCITY[0], VELOCITY[1])),
        tell(node, SET_LIMITS, &pair(limits[0], limits[1])),
        set_input_vel(node, 0.0),
    ])?;
    axis.takes(IDLE)?;
    let errors = axis.errors()?;
    if errors != 0 {
        return Err(device.wrong(format!("{}: expected an axis without errors", error_names(errors))));
    }
    if !floats(axis.get(GET_ENCODER_ESTIMATES)?)[0].is_finite() {
        return Err(device.wrong("its encoder gives no position"));
    }
    axis.prove_watchdog((1e9 * machine.watchdog()) as u64)?;
    Ok(Box::new(CansimpleSlot::new(node, device.drive, parameters)))
}

/// An axis that is being set up.
struct Axis<'a, L> {
    talk: Talk<'a, L>,
}

impl<L: Link> Axis<'_, L> {
    /// That something is wrong with it.
    fn wrong(&self, problem: impl Into<String>) -> CanError {
        self.talk.device.wrong(problem)
    }

    /// The next message of the axis until a deadline, ns.
    fn next(&mut self, deadline: u64) -> Result<Option<(u16, [u8; 8])>, CanError> {
        let node = self.talk.device.node;
        self.talk.next(deadline, |frame| command(node, frame))
    }

    /// What a message carries that is asked for.
    fn get(&mut self, asked: u16) -> Result<[u8; 8], CanError> {
        let node = self.talk.device.node;
        self.talk.answer(&ask(node, asked), |frame| content(node, asked, frame))
    }

    /// Sets a parameter where it has another value, and reads it back.
    fn set(&mut self, endpoints: &Endpoints, name: &str, value: f64) -> Result<(), CanError> {
        let parameter = endpoints.parameter(name, value).map_err(|problem| self.wrong(problem))?;
        if !self.has(&parameter)? {
            let (octets, length) = parameter.request(true);
            self.talk.send(&[tell(self.talk.device.node, RX_SDO, &octets[..length])])?;
            if !self.has(&parameter)? {
                return Err(self.wrong(format!("{name} does not take {value}")));
            }
        }
        Ok(())
    }

    /// Whether a parameter has its value.
    fn has(&mut self, parameter: &Parameter) -> Result<bool, CanError> {
        let (octets, length) = parameter.request(false);
        let node = self.talk.device.node;
        let see = |frame: &Frame| parameter.is_in(&content(node, TX_SDO, frame)?);
        let has = self.talk.try_answer(&tell(node, RX_SDO, &octets[..length]), see)?;
        has.ok_or_else(|| self.wrong(format!("does not say its parameter {:#x}", parameter.number)))
    }

    /// Its firmware, which is supported.
    fn identify(&mut self) -> Result<String, CanError> {
        let [_, _, _, _, major, minor, revision, _] = self.get(GET_VERSION)?;
        let node = self.talk.device.node;
        self.talk.is_alone(|frame| content(node, GET_VERSION, frame))?;
        let version = format!("{major}.{minor}.{revision}");
        if (major, minor) < (0, 6) {
            return Err(self.wrong(format!("firmware {version}: expected 0.6 or later")));
        }
        Ok(version)
    }

    /// Counts its heartbeats behind the first: a rate that has just been set holds from then on.
    fn count_heartbeats(&mut self) -> Result<(), CanError> {
        let mut now = self.talk.link.now();
        while self.next(now)?.is_some() {}
        let (mut end, mut count) = (now + STATE_TIME, None);
        while now < end {
            self.talk.pass(self.talk.period);
            now = self.talk.link.now();
            while let Some((command, _)) = self.next(now)? {
                match &mut count {
                    Some(count) => *count += u32::from(command == HEARTBEAT),
                    None if command == HEARTBEAT => (count, end) = (Some(0), now + COUNT_TIME),
                    None => {}
                }
            }
        }
        let (count, most) = (count.unwrap_or(0), COUNT_TIME / (u64::from(HEARTBEAT_MS) * 1_000_000));
        if f64::from(count) < COUNTED * most as f64 {
            let time = 1e-9 * COUNT_TIME as f64;
            let expected = format!("expected a heartbeat_msg_rate_ms of at most {HEARTBEAT_MS}");
            return Err(self.wrong(format!("{count} heartbeats in {time} s: {expected}")));
        }
        Ok(())
    }

    fn errors(&mut self) -> Result<u32, CanError> {
        let [active, of_disarming] = words(self.get(GET_ERROR)?);
        Ok(active | of_disarming)
    }

    /// Waits until its heartbeat shows a state, and feeds its watchdog once a period.
    fn takes(&mut self, state: u8) -> Result<(), CanError> {
        let end = self.talk.link.now() + STATE_TIME;
        let mut shown = "no heartbeat".to_owned();
        while self.talk.link.now() < end {
            self.talk.send(&[set_input_vel(self.talk.device.node, 0.0)])?;
            self.talk.pass(self.talk.period);
            let now = self.talk.link.now();
            while let Some((command, octets)) = self.next(now)? {
                let [errors, is] = words(octets);
                let is = is as u8;
                if command == HEARTBEAT && is == state {
                    return Ok(());
                }
                if command == HEARTBEAT {
                    shown = format!("{} with {}", state_name(is), error_names(errors));
                }
            }
        }
        Err(self.wrong(format!("{shown}: expected {} after it was asked for", state_name(state))))
    }

    /// Power at velocity 0, then silence: a watchdog of at most this time, ns, takes the power.
    fn prove_watchdog(&mut self, most: u64) -> Result<(), CanError> {
        let node = self.talk.device.node;
        self.talk.send(&[set_axis_state(node, CLOSED_LOOP)])?;
        let enabled = self.takes(CLOSED_LOOP);
        self.talk.pass((SILENCE * most as f64) as u64);
        // This one feeds it no more: the power is gone, or it stays.
        let errors = self.errors();
        self.talk.send(&[set_axis_state(node, IDLE), tell(node, CLEAR_ERRORS, &[0])])?;
        enabled?;
        match errors? {
            errors if errors & WATCHDOG_EXPIRED != 0 => self.takes(IDLE),
            0 => {
                let most = 1e-9 * most as f64;
                Err(self.wrong(format!(
                    "keeps its power for {:.3} s without commands: expected enable_watchdog and a \
                    watchdog_timeout of at most {most} s",
                    SILENCE * most
                )))
            }
            errors => Err(self.wrong(format!("{} at standstill", error_names(errors)))),
        }
    }
}

/// What a message of a node carries, where a frame is that one.
fn content(node: u8, of: u16, frame: &Frame) -> Option<[u8; 8]> {
    command(node, frame).filter(|(command, _)| *command == of).map(|(_, octets)| octets)
}
