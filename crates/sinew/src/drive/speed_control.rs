//! The velocity mode of a drive: limits of tension, speed and torque around its velocity loop.

use super::parameters::DriveParameters;
use super::velocity_loop::{VelocityLimits, VelocityLoop};
use crate::lanes::abreast;

/// Speed control of a drive, in its amplifier or, where the amplifier takes torques, in the control cycle.
///
/// ```text
/// tau = T^ r/n + velocity loop(w* - w^),    w* = v* n/r
/// ```
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | v*, w* | desired speed of the cable and of the motor | m/s, rad/s |
/// | T^, w^ | measured tension at the outlet and speed of the motor | N, rad/s |
/// | r, n | arm of the winch, ratio of the reducer | m, 1 |
///
/// The tension is fed forward; the integral of the loop compensates the losses of the reducer.
///
/// # Source
/// Textbook; limits of the tension are our own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedControl {
    velocity_loop: VelocityLoop,
}

abreast!(SpeedControlRows of SpeedControl { VelocityLoop: velocity_loop });

/// What the control of a shaft measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredShaft {
    /// At the outlet, N.
    pub tension: f64,
    /// Of the motor, rad/s.
    pub speed: f64,
    /// Cable per radian of the winch, m.
    pub arm: f64,
}

impl Default for SpeedControl {
    fn default() -> Self {
        Self::new()
    }
}

impl SpeedControl {
    /// At rest.
    #[must_use]
    pub fn new() -> Self {
        Self { velocity_loop: VelocityLoop::new(VelocityLoop::DRIVE_GAIN) }
    }

    /// Starts without a jump at the present speed of the motor, rad/s.
    #[inline(always)]
    pub fn take_over(&mut self, speed: f64) {
        self.velocity_loop.take_over(speed, 0.0);
    }

    /// Torque of the motor for the next `h` s, Nm, for a cable speed, m/s.
    #[inline(always)]
    pub fn torque(&mut self, drive: &DriveParameters, velocity: f64, measured: MeasuredShaft, h: f64) -> f64 {
        let velocity = drive.limited_speed(velocity, measured.tension);
        let per_ratio = 1.0 / drive.reducer.ratio;
        let turns = drive.reducer.ratio / measured.arm;
        let desired = (velocity * turns).max(-drive.motor.top_speed).min(drive.motor.top_speed);
        let holding = measured.tension.max(0.0) * measured.arm * per_ratio;
        let most = drive.motor.torque_constant * drive.motor.peak_current;
        let limits = VelocityLimits {
            acceleration: drive.acceleration * turns,
            torque: [-most - holding, most - holding],
        };
        holding + self.velocity_loop.torque(desired, measured.speed, drive.motor.inertia, limits, h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shaft_that_is_taken_over_is_only_held_against_its_tension() {
        let drive = DriveParameters::mc_am();
        let arm = drive.winch.arm(0);
        let (speed, tension) = (200.0, 150.0);
        let mut control = SpeedControl::new();
        control.take_over(speed);
        let velocity = speed * arm / drive.reducer.ratio;
        let torque = control.torque(&drive, velocity, MeasuredShaft { tension, speed, arm }, 1e-3);
        assert!((torque - tension * arm / drive.reducer.ratio).abs() < 1e-9, "{torque}");
    }

    #[test]
    fn the_motor_gives_the_torque_of_its_peak_current_and_not_more_whatever_the_tension() {
        let drive = DriveParameters::mc_am();
        let most = drive.motor.torque_constant * drive.motor.peak_current;
        for tension in [0.0, 200.0, 550.0] {
            for (speed, expected) in [(-1000.0, most), (1000.0, -most)] {
                let measured = MeasuredShaft { tension, speed, arm: drive.winch.arm(0) };
                let torque = SpeedControl::new().torque(&drive, 0.0, measured, 1e-3);
                assert!((torque - expected).abs() < 1e-15, "{tension} {speed}: {torque}");
            }
        }
    }
}
