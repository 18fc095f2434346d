//! An axis in operation: velocities to it, estimates and current back, its state in its heartbeat.

use super::{
    CLEAR_ERRORS, CLOSED_LOOP, GET_ENCODER_ESTIMATES, GET_IQ, HEARTBEAT, HEARTBEAT_MS, IDLE, ask, command,
    error_names, floats, set_axis_state, set_input_vel, state_name, tell, words,
};
use crate::can::slot::{Heard, Slot};
use crate::rest::braked_speed;
use sinew::drive::{DriveCommand, DriveParameters};
use sinew::machine::DriveDevice;
use sinew_segment::CanFrame as Frame;

/// Time without its heartbeat after which that is lost, ns.
const PATIENCE: u64 = 5 * HEARTBEAT_MS as u64 * 1_000_000;
/// Time after which a state that the axis has not taken is asked for again, ns.
const AGAIN: u64 = 250_000_000;

/// One axis of a running machine.
#[derive(Debug)]
pub(super) struct CansimpleSlot {
    node: u8,
    device: DriveDevice,
    parameters: DriveParameters,
    /// State in its last heartbeat, 0 before the first, and the errors in it; all errors of this run.
    state: u8,
    shown: u32,
    errors: u32,
    /// The state that it is to have, and when it was asked for, ns.
    goal: u8,
    asked: Option<u64>,
    /// Whether it has lost its power without being told: it is not enabled again.
    left: bool,
    /// Which of the readings of a cycle have come: estimates, current.
    came: [bool; 2],
    /// Angle of the motor, rad, and its current, A, + winds in.
    angle: f64,
    current: f64,
    /// Speed of the cable that was commanded last, m/s.
    commanded: f64,
}

impl CansimpleSlot {
    pub(super) fn new(node: u8, device: DriveDevice, parameters: DriveParameters) -> Self {
        Self {
            node,
            device,
            parameters,
            state: 0,
            shown: 0,
            errors: 0,
            goal: IDLE,
            asked: None,
            left: false,
            came: [false; 2],
            angle: f64::NAN,
            current: f64::NAN,
            commanded: 0.0,
        }
    }

    /// The cable, m, and its change with the angle of the motor, m/rad.
    fn cable(&self) -> [f64; 2] {
        DriveDevice::cable(&self.parameters.winch, self.parameters.reducer.ratio, self.angle)
    }

    /// Velocity, turns/s, of a command; a tension cannot be followed without one that is measured, and there
    /// is no brake: the axis stands.
    fn set_point(&mut self, command: DriveCommand) -> f32 {
        let [_, per_radian] = self.cable();
        self.commanded = match command {
            DriveCommand::Velocity(velocity) if self.is_enabled() && (velocity / per_radian).is_finite() => {
                velocity
            }
            _ => 0.0,
        };
        let turns = self.commanded / per_radian * (self.device.counts_per_turn / core::f64::consts::TAU);
        if self.commanded == 0.0 { 0.0 } else { turns as f32 }
    }

    fn heartbeat(&mut self, errors: u32, state: u8) -> Heard {
        let lost = self.is_enabled() && self.goal == CLOSED_LOOP && state != CLOSED_LOOP;
        (self.state, self.shown, self.errors) = (state, errors, self.errors | errors);
        self.left |= lost || errors != 0;
        Heard::Alive { left: lost && errors == 0 }
    }
}

impl Slot for CansimpleSlot {
    fn sends(&self, frame: &Frame) -> bool {
        frame.id() >> 5 == u16::from(self.node)
    }

    fn operate(&self, begin: bool) -> Frame {
        if begin { tell(self.node, CLEAR_ERRORS, &[0]) } else { set_axis_state(self.node, IDLE) }
    }

    fn command(&mut self, command: DriveCommand, _h: f64, now: u64, out: &mut Vec<Frame>) {
        let goal = match command {
            DriveCommand::Off => IDLE,
            DriveCommand::Brake => self.goal,
            _ if self.left => IDLE,
            _ => CLOSED_LOOP,
        };
        let again = self.asked.is_none_or(|at| now.saturating_sub(at) >= AGAIN);
        if goal != self.goal || (goal != self.state && again) {
            (self.goal, self.asked) = (goal, Some(now));
            out.push(set_axis_state(self.node, goal));
        }
        out.push(set_input_vel(self.node, self.set_point(command)));
        out.push(ask(self.node, GET_ENCODER_ESTIMATES));
        out.push(ask(self.node, GET_IQ));
        self.came = [false; 2];
    }

    fn take(&mut self, frame: &Frame) -> Heard {
        match command(self.node, frame) {
            Some((HEARTBEAT, octets)) => {
                let [errors, state] = words(octets);
                return self.heartbeat(errors, state as u8);
            }
            Some((GET_ENCODER_ESTIMATES, octets)) => {
                (self.angle, self.came[0]) = (self.device.angle(floats(octets)[0]), true);
            }
            Some((GET_IQ, octets)) => {
                (self.current, self.came[1]) =
                    (floats(octets)[1] * self.device.counts_per_turn.signum(), true);
            }
            _ => return Heard::Other,
        }
        if self.came == [true; 2] { Heard::Readings } else { Heard::Other }
    }

    fn patience(&self) -> u64 {
        PATIENCE
    }

    fn is_ready(&self) -> bool {
        self.state == IDLE && self.shown == 0
    }

    fn state(&self) -> String {
        format!("{} with {}", state_name(self.state), error_names(self.shown))
    }

    fn is_enabled(&self) -> bool {
        self.state == CLOSED_LOOP
    }

    fn has_torque(&self) -> bool {
        self.state != IDLE
    }

    fn fault(&self) -> Option<u16> {
        (self.errors != 0).then(|| self.errors.trailing_zeros() as u16 + 1)
    }

    fn forgive(&mut self) {
        (self.errors, self.left) = (0, false);
    }

    fn forget_state(&mut self) {
        self.state = 0;
    }

    fn readings(&self) -> [f64; 2] {
        [self.cable()[0], self.current]
    }

    fn braked_speed(&self, h: f64) -> f64 {
        braked_speed(&self.parameters, self.commanded, h)
    }
}
