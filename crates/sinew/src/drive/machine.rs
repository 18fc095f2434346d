//! The whole drive: sensors, loops, motor, reducer, winch, one step of a millisecond.

use super::exchange::{DriveCommand, DriveReading, DriveStep};
use super::lanes::DriveLanes;
use super::parameters::DriveParameters;
use crate::Error;
use crate::dispatch::InstructionSet;

/// A simulated drive.
///
/// Semi-implicit: the shaft moves under the tension of the previous step, then the cable moves. With 100 kg
/// and more reflected to the cable and 24 N/mm, a millisecond is about 1 % of a period of oscillation.
///
/// # Example
/// ```
/// use sinew::drive::{Drive, DriveCommand, DriveParameters};
/// let mut drive = Drive::new(DriveParameters::mc_am(), 1)?;
/// let mut pulled = 0.0;
/// for _ in 0..1000 {
///     pulled += drive.step(DriveCommand::Velocity(0.05), 100.0, 1e-3).moved;
/// }
/// assert!((pulled - 0.05).abs() < 2e-3); // a second at 50 mm/s against 100 N
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Drive {
    parameters: DriveParameters,
    pub(super) lane: DriveLanes<1>,
}

/// Step of a drive, s.
const STEP: f64 = 1e-3;

impl Drive {
    /// A drive at rest, half of its drum wound, for steps of a millisecond; `seed` is that of its sensors'
    /// noise.
    ///
    /// # Errors
    /// As [`DriveParameters::validate`].
    pub fn new(parameters: DriveParameters, seed: u64) -> Result<Self, Error> {
        Self::in_steps(parameters, seed, STEP)
    }

    /// The same for steps of `step` s: the delay of its sensors is that number of them.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_steps(parameters: DriveParameters, seed: u64, step: f64) -> Result<Self, Error> {
        parameters.validate()?;
        crate::error::positive("step", step)?;
        Ok(Self { parameters, lane: DriveLanes::new(parameters, seed, step)? })
    }

    /// Its parameters.
    #[must_use]
    pub fn parameters(&self) -> &DriveParameters {
        &self.parameters
    }

    /// The latest measurements.
    #[must_use]
    pub fn reading(&self) -> DriveReading {
        self.lane.reading(0)
    }

    /// Temperature of the winding, degrees Celsius.
    #[must_use]
    pub fn winding(&self) -> f64 {
        self.lane.winding(0)
    }

    /// Cable on the drum, m.
    #[must_use]
    pub fn wound(&self) -> f64 {
        self.lane.state(0).wound
    }

    /// Kinetic energy of the rotor, J.
    #[must_use]
    pub fn kinetic(&self) -> f64 {
        let speed = self.lane.state(0).speed;
        0.5 * self.parameters.motor.inertia * speed * speed
    }

    /// Energy in the rotor's motion and the winding's field, J.
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.kinetic() + self.lane.state(0).motor.field(&self.parameters.motor)
    }

    /// Heat stored in winding and housing above room temperature, J.
    #[must_use]
    pub fn warmth(&self) -> f64 {
        self.lane.state(0).motor.warmth(&self.parameters.motor)
    }

    /// Its steady state under a cable tension, N: the tension keeps the winch on one flank of the reducer.
    pub fn settle(&mut self, tension: f64) {
        self.lane.settle(tension);
    }

    /// Measurements of a drive that stands under a cable tension, N.
    pub fn stand(&mut self, tension: f64) {
        self.lane.stand(tension);
    }

    /// Executes a command for `h` seconds under a cable tension, N. A command that is not finite counts as
    /// [`DriveCommand::Off`], such a tension as 0.
    pub fn step(&mut self, command: DriveCommand, tension: f64, h: f64) -> DriveStep {
        let mut step = [DriveStep::STANDING];
        self.lane.step(InstructionSet::Baseline, |_| (command, tension), h, &mut step);
        step[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::DriveFault;
    use crate::drive::state::{DriveState, Powered};
    use crate::drive::{Encoder, LoadCell, ROOM, Reducer};
    use crate::lanes::{Abreast, Row};

    const H: f64 = 1e-3;

    /// The paper's drive with sensors that neither round, scatter nor delay.
    fn exact() -> DriveParameters {
        let load_cell = LoadCell { noise: 0.0, resolution: 0.0, ..LoadCell::one_kilonewton() };
        let encoder = Encoder { counts: 1e9, zero: 0.0 };
        DriveParameters { load_cell, encoder, delay_ms: 0.0, ..DriveParameters::mc_am() }
    }

    /// Cable per radian of the winch.
    fn arm(drive: &Drive) -> f64 {
        drive.lane.drum.arm(Row(drive.lane.state.winch)).0[0]
    }

    /// Torque of the motor that balances a tension, losses aside.
    fn holding(drive: &Drive, tension: f64) -> f64 {
        tension * arm(drive) / drive.parameters.reducer.ratio
    }

    #[test]
    fn a_command_that_is_not_finite_switches_the_amplifier_off() {
        let mut drive = Drive::new(exact(), 1).unwrap();
        for _ in 0..100 {
            drive.step(DriveCommand::Velocity(0.05), 100.0, H);
        }
        let off = drive.clone().step(DriveCommand::Off, 100.0, H);
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for command in [
                DriveCommand::Current(wrong),
                DriveCommand::Velocity(wrong),
                DriveCommand::Tension { tension: wrong, feed: 0.0 },
                DriveCommand::Tension { tension: 100.0, feed: wrong },
            ] {
                assert_eq!(drive.clone().step(command, 100.0, H), off, "{command:?}");
            }
        }
    }

    #[test]
    fn a_drive_that_reverses_stands_over_its_reversal_travel_and_not_much_less() {
        for (efficiency, tension, speed) in [(0.6, 550.0, 0.004), (0.7, 450.0, 0.003), (0.85, 300.0, 0.002)] {
            let reducer = Reducer { efficiency, ..Reducer::ratio_53() };
            let mut drive = Drive::new(DriveParameters { reducer, ..exact() }, 1).unwrap();
            for _ in 0..1500 {
                drive.step(DriveCommand::Velocity(speed), tension, H);
            }
            for side in [-1.0, 1.0] {
                // The speed changes within the first cycles; then the shaft is held by friction.
                let command = DriveCommand::Velocity(side * speed);
                let stood = (0..2000).filter(|_| drive.step(command, tension, H).moved * side < 1e-9).count();
                let fraction = speed * H * stood as f64 / (drive.parameters.reversal_travel() * tension);
                assert!((0.6..1.0).contains(&fraction), "{efficiency} {side}: {fraction}");
            }
        }
    }

    #[test]
    fn speed_control_takes_over_a_turning_shaft_without_a_jump_of_the_torque() {
        let parameters = exact();
        let mut drive = Drive::new(parameters, 1).unwrap();
        let tension = 100.0;
        drive.settle(tension);
        let current = 1.5 * parameters.pulling_current(tension, 0.0);
        let mut speed = 0.0;
        for _ in 0..50 {
            speed = drive.step(DriveCommand::Current(current), tension, H).speed;
        }
        assert!(speed > 0.03, "{speed}");
        drive.step(DriveCommand::Velocity(speed), tension, H);
        let expected = holding(&drive, tension);
        let torque = drive.lane.state(0).torque;
        assert!((torque - expected).abs() < 1e-8 * expected, "{torque} {expected}");
    }

    #[test]
    fn tension_control_that_is_entered_again_has_forgotten_its_integral() {
        let mut drive = Drive::new(exact(), 1).unwrap();
        let tension = 100.0;
        drive.settle(tension);
        for _ in 0..100 {
            drive.step(DriveCommand::Tension { tension: 2.0 * tension, feed: 0.0 }, tension, H);
        }
        drive.step(DriveCommand::Brake, tension, H);
        drive.step(DriveCommand::Tension { tension, feed: 0.0 }, tension, H);
        let expected = holding(&drive, tension);
        let torque = drive.lane.state(0).torque;
        assert!((torque - expected).abs() < 1e-15, "{torque} {expected}");
    }

    #[test]
    fn without_tension_the_winch_follows_the_motor_with_the_play_of_the_backlash() {
        let mut drive = Drive::new(exact(), 1).unwrap();
        let Reducer { ratio, backlash, .. } = drive.parameters.reducer;
        let arm = arm(&drive);
        // Steps of the motor in backlashes, and how far the winch follows from the middle between the flanks
        // on.
        for (turned, follows) in [(0.4, 0.0), (0.2, 0.1), (-0.9, 0.0), (-0.3, -0.2), (0.8, 0.0), (0.5, 0.3)] {
            let mut state = drive.lane.state(0);
            let before = state.winch;
            state.advance(backlash, turned * backlash * ratio / H, 1.0 / ratio, 0.0, H);
            state.set(&mut drive.lane.state, 0);
            let moved = (state.winch - before) * arm;
            assert!((moved - follows * backlash * arm).abs() < 1e-12, "{turned}: {moved}");
        }
    }

    #[test]
    fn tension_lays_the_winch_on_a_flank_and_a_slack_cable_leaves_it_between_them() {
        let off = |tension: f64| {
            let mut drive = Drive::new(exact(), 1).unwrap();
            drive.settle(tension);
            drive.reading().position - drive.wound()
        };
        let parameters = exact();
        let half = 0.5 * parameters.reducer.backlash * parameters.winch.arm(0);
        assert!(off(0.0).abs() < 1e-11, "{}", off(0.0));
        assert!((off(100.0) - half).abs() < 1e-11, "{} {half}", off(100.0));
    }

    #[test]
    fn what_lies_beyond_a_limit_is_a_fault_and_the_limit_is_not() {
        let fault = |change: &dyn Fn(&mut DriveState)| {
            let mut drive = Drive::new(exact(), 1).unwrap();
            let mut state = drive.lane.state(0);
            change(&mut state);
            state.set(&mut drive.lane.state, 0);
            drive.lane.check_faults(0);
            drive.lane.fault[0]
        };
        let (full, hottest) = (exact().winch.full(), exact().motor.hottest);
        assert_eq!(fault(&|state| state.winch = 0.0), None);
        assert_eq!(fault(&|state| state.winch = full), None);
        assert_eq!(fault(&|state| state.motor.winding = hottest), None);
        assert_eq!(fault(&|state| state.winch = -1e-9), Some(DriveFault::DrumEmpty));
        assert_eq!(fault(&|state| state.winch = full + 1e-9), Some(DriveFault::DrumFull));
        let winding = hottest + 1e-9;
        assert_eq!(fault(&|state| state.motor.winding = winding), Some(DriveFault::Hot { winding }));
    }

    #[test]
    fn a_winding_warms_to_its_fault_which_a_braked_drive_still_reports() {
        let mut parameters = exact();
        // Hot within a fraction of a second.
        parameters.motor.winding_capacity = 0.15;
        let mut drive = Drive::new(parameters, 1).unwrap();
        assert!((drive.winding() - ROOM).abs() < 1e-15);
        let most = parameters.motor.peak_current;
        let blocking = 1.1 * parameters.tension_of(most);
        let fault = (0..400).find_map(|_| drive.step(DriveCommand::Current(most), blocking, H).fault);
        assert!(drive.winding() > parameters.motor.hottest);
        assert_eq!(fault, Some(DriveFault::Hot { winding: drive.winding() }));
        assert_eq!(drive.step(DriveCommand::Brake, blocking, H).fault, fault);
    }

    #[test]
    fn a_fast_shaft_is_braked_with_all_of_the_voltage_where_the_desired_current_needs_more() {
        let mut parameters = exact();
        (parameters.motor.resistance, parameters.motor.voltage) = (2.0, 12.0);
        let drive = Drive::new(parameters, 1).unwrap();
        let desired = -parameters.motor.torque_constant * parameters.motor.peak_current;
        let mut state = DriveState { speed: 300.0, torque: desired, ..drive.lane.state(0) };
        state.motor.prepare(&parameters.motor, H);
        let Powered { winding, electrical, .. } = state.power(&parameters, true, 0.0, H);
        assert!(winding.mean < -5.0, "{} A", winding.mean);
        let voltage = electrical / (winding.mean * H);
        assert!((voltage + parameters.motor.voltage).abs() < 1e-12, "{voltage} V");
    }
}
