//! A controller in operation: velocities to it, position and torque back.

use super::{
    CODES, FAULT, POSITION, Readings, STOPPED, TIMEOUT, fault_name, follow, mode_name, readings, stop,
};
use crate::can::slot::{Heard, Slot};
use crate::rest::braked_speed;
use sinew::drive::{DriveCommand, DriveParameters};
use sinew::machine::DriveDevice;
use sinew_segment::CanFrame as Frame;

/// One controller of a running machine.
#[derive(Debug)]
pub(super) struct MoteusSlot {
    node: u8,
    device: DriveDevice,
    parameters: DriveParameters,
    /// Torque, N m, at most, and time for which a command counts, s.
    torque: f32,
    timeout: f32,
    /// Mode in its last answer, 255 before the first; code of its first fault in this run.
    mode: u8,
    fault: Option<u16>,
    /// Whether it is to follow commands, and whether it has since then.
    wanted: bool,
    followed: bool,
    /// Whether it has lost its power, or followed no more, without being told: it is not enabled again.
    left: bool,
    /// Angle of the motor, rad, and its current, A, + winds in.
    angle: f64,
    current: f64,
    /// Speed of the cable that was commanded last, m/s.
    commanded: f64,
}

impl MoteusSlot {
    pub(super) fn new(node: u8, device: DriveDevice, parameters: DriveParameters, timeout: f64) -> Self {
        let motor = parameters.motor;
        let torque = motor.torque_constant * motor.peak_current / device.counts_per_turn.abs();
        Self {
            node,
            device,
            parameters,
            torque: torque as f32,
            timeout: timeout as f32,
            mode: u8::MAX,
            fault: None,
            wanted: false,
            followed: false,
            left: false,
            angle: f64::NAN,
            current: f64::NAN,
            commanded: 0.0,
        }
    }

    /// Holds still, with power.
    pub(super) fn stand(&self) -> Frame {
        follow(self.node, 0.0, self.torque, self.timeout)
    }

    /// The cable, m, and its change with the angle of the motor, m/rad.
    fn cable(&self) -> [f64; 2] {
        DriveDevice::cable(&self.parameters.winch, self.parameters.reducer.ratio, self.angle)
    }

    fn see(&mut self, shown: Readings) -> Heard {
        self.mode = shown.mode;
        self.angle = self.device.angle(shown.position);
        self.current = shown.torque * self.device.counts_per_turn / self.parameters.motor.torque_constant;
        let fault = match shown.mode {
            FAULT => Some(CODES + u16::from(shown.fault)),
            TIMEOUT => Some(CODES + u16::from(TIMEOUT)),
            _ => None,
        };
        self.fault = self.fault.or(fault);
        let lost = self.followed && shown.mode != POSITION;
        self.followed |= self.wanted && shown.mode == POSITION;
        self.left |= lost || fault.is_some();
        if lost && fault.is_none() { Heard::Left } else { Heard::Readings }
    }
}

impl Slot for MoteusSlot {
    fn sends(&self, frame: &Frame) -> bool {
        frame.id() == u16::from(self.node) << 8
    }

    fn operate(&self, _begin: bool) -> Frame {
        stop(self.node)
    }

    fn command(&mut self, command: DriveCommand, _h: f64, _now: u64, out: &mut Vec<Frame>) {
        self.wanted = match command {
            DriveCommand::Off => false,
            DriveCommand::Brake => self.wanted,
            _ => true,
        } && !self.left;
        self.followed &= self.wanted;
        let [_, per_radian] = self.cable();
        // A tension cannot be followed without one that is measured, and there is no brake: it stands.
        self.commanded = match command {
            DriveCommand::Velocity(velocity) if self.followed && (velocity / per_radian).is_finite() => {
                velocity
            }
            _ => 0.0,
        };
        if !self.wanted {
            return out.push(stop(self.node));
        }
        let turns = self.commanded / per_radian * (self.device.counts_per_turn / core::f64::consts::TAU);
        let turns = if self.commanded == 0.0 { 0.0 } else { turns as f32 };
        out.push(follow(self.node, turns, self.torque, self.timeout));
    }

    fn take(&mut self, frame: &Frame) -> Heard {
        readings(self.node, frame).map_or(Heard::Other, |shown| self.see(shown))
    }

    /// Every answer says what a heartbeat would.
    fn patience(&self) -> u64 {
        u64::MAX
    }

    fn is_ready(&self) -> bool {
        self.mode == STOPPED
    }

    fn state(&self) -> String {
        self.fault.map_or_else(|| mode_name(self.mode), fault_name)
    }

    fn is_enabled(&self) -> bool {
        self.mode == POSITION
    }

    fn has_torque(&self) -> bool {
        !matches!(self.mode, STOPPED | FAULT)
    }

    fn fault(&self) -> Option<u16> {
        self.fault
    }

    fn forgive(&mut self) {
        (self.fault, self.left) = (None, false);
    }

    fn forget_state(&mut self) {
        self.mode = u8::MAX;
    }

    fn readings(&self) -> [f64; 2] {
        [self.cable()[0], self.current]
    }

    fn braked_speed(&self, h: f64) -> f64 {
        braked_speed(&self.parameters, self.commanded, h)
    }
}
