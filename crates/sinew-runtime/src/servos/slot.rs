//! A servo in the cycle: commands in SI units to goals, its reading to the cable.

use super::device::{OperatingMode, ServoDevice};
use super::registers::sts;
use super::series::Series;
use crate::rest::braked_speed;
use sinew::drive::{DriveCommand, DriveParameters, MeasuredShaft, SpeedControl};
use sinew::machine::DriveDevice;

/// One servo of a running machine.
#[derive(Debug, Clone)]
pub(super) struct Slot {
    pub(super) device: ServoDevice,
    pub(super) line: usize,
    parameters: DriveParameters,
    /// Whether it is to have torque, and had to when the last reading was asked for.
    pub(super) torque: bool,
    pub(super) expected: bool,
    /// Cycles without a reading.
    pub(super) silent: u32,
    /// The last reading; of a servo that is silent, an earlier one.
    pub(super) reading: Reading,
    /// Its count over all turns: none before the first reading, NaN where it has turned too far unseen.
    count: Option<f64>,
    /// Angle and speed of the motor, rad and rad/s, as read last.
    angle: f64,
    speed: f64,
    /// Speed of the cable that was commanded last, m/s.
    commanded: f64,
    /// Goal before it was rounded less the goal, counts: it is made up for in the next cycle.
    rest: f64,
    /// Position as it shows it, counts.
    shown: f64,
    /// Where it is to be, as it would show that, counts.
    position: f64,
    speed_control: SpeedControl,
}

/// What a servo says of itself in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    pub(super) torque: bool,
    /// Whether its watchdog has stopped it.
    pub(super) timed_out: bool,
    pub(super) error: u8,
    /// degC.
    pub(super) temperature: f64,
    /// Current of the motor, A, + winds in; NaN where it measures none.
    pub(super) current: f64,
    /// Position of the cable, m.
    pub(super) cable: f64,
}

impl Slot {
    pub(super) fn new(device: ServoDevice, line: usize, parameters: DriveParameters) -> Self {
        let (temperature, current, cable) = (f64::NAN, f64::NAN, f64::NAN);
        let reading = Reading { torque: false, timed_out: false, error: 0, temperature, current, cable };
        Self {
            line,
            parameters,
            torque: false,
            expected: false,
            silent: 0,
            reading,
            count: None,
            angle: f64::NAN,
            speed: 0.0,
            commanded: 0.0,
            rest: 0.0,
            shown: 0.0,
            position: 0.0,
            speed_control: SpeedControl::new(),
            device,
        }
    }

    pub(super) fn muscle(&self) -> usize {
        self.device.drive.muscle
    }

    /// Address of its goal, and its octets.
    pub(super) fn goal_place(&self) -> (u16, usize) {
        let registers = self.device.model.series.registers();
        match self.device.mode {
            OperatingMode::Velocity if self.device.model.series == Series::Sts => (sts::GOAL_SPEED, 2),
            OperatingMode::ExtendedPosition if self.device.model.series == Series::Sts => {
                (sts::GOAL_POSITION, 2)
            }
            OperatingMode::Current => (registers.goal_current, 2),
            OperatingMode::Velocity => (registers.goal_velocity(), 4),
            OperatingMode::ExtendedPosition => (registers.goal_position, 4),
        }
    }

    /// Takes over a reading, `age` s after the one before; whether it is one.
    pub(super) fn read(&mut self, data: &[u8], age: f64) -> bool {
        let Some(measured) = self.device.model.series.measured(data) else { return false };
        self.shown = f64::from(measured.position);
        let count = match self.device.model.series {
            Series::X | Series::P => self.shown,
            Series::Sts => self.over_turns(self.shown, age),
        };
        self.count = Some(count);
        let Self { device, parameters, .. } = self;
        let (drive, sign) = (&device.drive, device.drive.counts_per_turn.signum());
        self.angle = drive.angle(count);
        self.speed =
            f64::from(measured.velocity) * device.model.velocity_unit() * sign * parameters.reducer.ratio;
        let unit = if device.model.current_a > 0.0 { device.model.current_a } else { f64::NAN };
        let [cable, _] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, self.angle);
        self.reading = Reading {
            torque: measured.torque,
            timed_out: measured.timed_out,
            error: measured.error,
            temperature: f64::from(measured.temperature),
            current: f64::from(measured.current) * unit * sign,
            cable,
        };
        true
    }

    /// The count over all turns that follows the last one, of a position that is known within a turn; NaN,
    /// from then on, where half a turn can have gone unseen.
    fn over_turns(&self, position: f64, age: f64) -> f64 {
        let model = &self.device.model;
        let Some(last) = self.count else { return position };
        if age * f64::from(model.max_velocity) > 0.5 * model.counts {
            return f64::NAN;
        }
        let ahead = (position - last).rem_euclid(model.counts);
        last + if ahead < 0.5 * model.counts { ahead } else { ahead - model.counts }
    }

    /// The goal of a command, in the unit of the register; `h` s since the last one.
    pub(super) fn goal(&mut self, command: DriveCommand, h: f64) -> i32 {
        let began = !self.torque;
        self.torque = command != DriveCommand::Off;
        if began || !self.torque {
            self.position = self.shown;
        }
        if began {
            self.rest = 0.0;
            self.speed_control.take_over(self.speed);
        }
        let (parameters, drive) = (self.parameters, self.device.drive);
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, self.angle);
        // A tension cannot be followed without one that is measured, and there is no brake: it stands.
        let velocity = match command {
            DriveCommand::Velocity(velocity) if velocity.is_finite() && per_radian.is_finite() => velocity,
            _ => 0.0,
        };
        self.commanded = velocity;
        let (motor, sign) = (velocity / per_radian, drive.counts_per_turn.signum());
        match self.device.mode {
            OperatingMode::Velocity => {
                let horn = motor / parameters.reducer.ratio * sign;
                self.rounded(horn / self.device.model.velocity_unit(), velocity != 0.0)
            }
            OperatingMode::ExtendedPosition => {
                let speed = motor * (drive.counts_per_turn / core::f64::consts::TAU);
                let speed = if speed.is_finite() { speed } else { 0.0 };
                let most = self.device.model.series.largest_position();
                self.position = (self.position + speed * h).clamp(-most, most);
                (self.position + speed * self.device.position_lag).clamp(-most, most).round() as i32
            }
            OperatingMode::Current => {
                let current = match command {
                    DriveCommand::Current(current) => {
                        self.commanded = self.speed * per_radian;
                        current
                    }
                    DriveCommand::Off => 0.0,
                    _ => {
                        let arm = per_radian * parameters.reducer.ratio;
                        let measured = MeasuredShaft { tension: 0.0, speed: self.speed, arm };
                        let torque = self.speed_control.torque(&parameters, velocity, measured, h);
                        torque / parameters.motor.torque_constant
                    }
                };
                (current * sign / self.device.model.current_a).round() as i32
            }
        }
    }

    /// Rounds a goal; what that leaves is made up for later, so that slow motions are right in the mean.
    fn rounded(&mut self, goal: f64, moves: bool) -> i32 {
        let wanted = if moves && goal.is_finite() { goal + self.rest } else { 0.0 };
        let rounded = wanted.round();
        self.rest = wanted - rounded;
        let most = f64::from(self.device.model.max_velocity);
        rounded.clamp(-most, most) as i32
    }

    /// As [`braked_speed`].
    pub(super) fn braked_speed(&self, h: f64) -> f64 {
        braked_speed(&self.parameters, self.commanded, h)
    }
}
