//! A motor in operation: positions and velocities to it, position and torque back.

use super::{Answer, BEYOND, LAGS, MitMotor, TRAVEL, answer, enter, fault_name, is_answer, leave};
use crate::can::device::CanDevice;
use crate::can::slot::{Heard, Slot};
use crate::rest::braked_speed;
use core::f64::consts::TAU;
use sinew::drive::{DriveCommand, DriveParameters};
use sinew::machine::DriveDevice;
use sinew_segment::{CanFrame as Frame, MitCommand, MitRanges};

/// Cycles in which a motor is told in turn where it is and to follow, one of which may be lost.
const ENTERING: u32 = 6;
/// Time for which a motor may be as far behind as its torque lets it, s.
const LAG_TIME: f64 = 0.1;

/// One motor of a running machine.
#[derive(Debug)]
pub(super) struct MitSlot {
    node: u8,
    ranges: MitRanges,
    /// N m/rad and N m s/rad.
    stiffness: f64,
    damping: f64,
    device: DriveDevice,
    parameters: DriveParameters,
    /// Position error, rad, that takes its peak torque.
    lead: f64,
    /// Cycles since it has been told to follow; none while it is told to leave.
    told: Option<u32>,
    /// Whether it has power by its last answer, none before that: by what it shows, or by what it was told.
    power: Option<bool>,
    fault: Option<u16>,
    /// Whether it has lost its power without being told: it is not enabled again.
    left: bool,
    /// Position of its shaft that it shall have and has, rad, and how long that lags behind, s.
    goal: f64,
    position: f64,
    lags: f64,
    /// Angle of the motor, rad, and its current, A, + winds in.
    angle: f64,
    current: f64,
    /// Speed of the cable that was commanded last, m/s.
    commanded: f64,
}

impl MitSlot {
    pub(super) fn new(device: &CanDevice, motor: &MitMotor, parameters: DriveParameters) -> Self {
        let peak = parameters.motor.torque_constant * parameters.motor.peak_current;
        let peak = (peak / device.drive.counts_per_turn.abs()).min(motor.ranges.torque);
        Self {
            node: device.node,
            ranges: motor.ranges,
            stiffness: motor.stiffness,
            damping: motor.damping,
            device: device.drive,
            parameters,
            lead: peak / motor.stiffness,
            told: None,
            power: None,
            fault: None,
            left: false,
            goal: f64::NAN,
            position: f64::NAN,
            lags: 0.0,
            angle: f64::NAN,
            current: f64::NAN,
            commanded: 0.0,
        }
    }

    /// The cable, m, and its change with the angle of the motor, m/rad.
    fn cable(&self) -> [f64; 2] {
        DriveDevice::cable(&self.parameters.winch, self.parameters.reducer.ratio, self.angle)
    }

    /// Whether it has been told to follow for so long that it does.
    fn follows(&self) -> bool {
        self.told.is_some_and(|cycles| cycles >= ENTERING)
    }

    fn see(&mut self, shown: Answer) -> Heard {
        let before = self.power;
        self.power = Some(shown.power.unwrap_or(self.told.is_some()));
        self.position = shown.readings.position;
        self.angle = self.device.angle(self.position / TAU);
        let turn = self.device.counts_per_turn;
        self.current = match self.ranges.current {
            Some(_) => shown.readings.torque * turn.signum(),
            None => shown.readings.torque * turn / self.parameters.motor.torque_constant,
        };
        let beyond = self.told.is_some() && self.position.abs() > TRAVEL * self.ranges.position;
        let fault = shown.fault.or(beyond.then_some(BEYOND));
        self.fault = self.fault.or(fault);
        let lost = self.told.is_some() && before == Some(true) && self.power == Some(false);
        self.left |= lost || shown.fault.is_some();
        if lost && fault.is_none() { Heard::Left } else { Heard::Readings }
    }

    /// The goal goes on with a velocity of the shaft, rad/s, for `h` s: within its range, and not further
    /// ahead than the torque reaches.
    fn advance(&mut self, velocity: f64, h: f64) {
        let (most, goal) = (TRAVEL * self.ranges.position, self.goal + velocity * h);
        let [low, high] = [self.position - self.lead, self.position + self.lead];
        self.lags = if goal < low || goal > high { self.lags + h } else { 0.0 };
        if self.lags > LAG_TIME {
            self.fault = self.fault.or(Some(LAGS));
        }
        self.goal = goal.max(low).min(high).max(-most).min(most);
    }
}

impl Slot for MitSlot {
    fn sends(&self, frame: &Frame) -> bool {
        is_answer(frame, self.node, self.ranges.family)
    }

    fn operate(&self, _begin: bool) -> Frame {
        leave(self.node)
    }

    fn command(&mut self, command: DriveCommand, h: f64, _now: u64, out: &mut Vec<Frame>) {
        let wanted = match command {
            DriveCommand::Off => false,
            DriveCommand::Brake => self.told.is_some(),
            _ => true,
        } && !self.left
            && self.position.is_finite();
        if !wanted {
            (self.told, self.commanded) = (None, 0.0);
            return out.push(leave(self.node));
        }
        let cycles = self.told.map_or(0, |cycles| cycles.saturating_add(1));
        self.told = Some(cycles);
        let [_, per_radian] = self.cable();
        // A tension cannot be followed without one that is measured, and there is no brake: it stands.
        self.commanded = match command {
            DriveCommand::Velocity(velocity) if self.follows() && (velocity / per_radian).is_finite() => {
                velocity
            }
            _ => 0.0,
        };
        let velocity = self.commanded / per_radian * self.device.counts_per_turn;
        let velocity = if self.commanded == 0.0 { 0.0 } else { velocity };
        if self.follows() {
            self.advance(velocity, h);
        } else {
            (self.goal, self.lags) = (self.position, 0.0);
            if cycles % 2 == 1 {
                return out.push(enter(self.node));
            }
        }
        let (stiffness, damping) = (self.stiffness, self.damping);
        let command = MitCommand { position: self.goal, velocity, stiffness, damping, torque: 0.0 };
        out.push(Frame::new(u16::from(self.node), &self.ranges.command(&command)));
    }

    fn take(&mut self, frame: &Frame) -> Heard {
        answer(self.node, &self.ranges, frame).map_or(Heard::Other, |shown| self.see(shown))
    }

    /// Every answer says what a heartbeat would.
    fn patience(&self) -> u64 {
        u64::MAX
    }

    fn is_ready(&self) -> bool {
        self.power == Some(false) && self.fault.is_none()
    }

    fn state(&self) -> String {
        match (self.fault, self.power) {
            (Some(fault), _) => fault_name(fault),
            (None, Some(true)) => "with power".to_owned(),
            (None, _) => "without power".to_owned(),
        }
    }

    fn is_enabled(&self) -> bool {
        self.follows() && self.power == Some(true)
    }

    fn has_torque(&self) -> bool {
        self.power != Some(false)
    }

    fn fault(&self) -> Option<u16> {
        self.fault
    }

    fn forgive(&mut self) {
        (self.fault, self.left) = (None, false);
    }

    fn forget_state(&mut self) {
        self.power = None;
    }

    fn readings(&self) -> [f64; 2] {
        [self.cable()[0], self.current]
    }

    fn braked_speed(&self, h: f64) -> f64 {
        braked_speed(&self.parameters, self.commanded, h)
    }
}
