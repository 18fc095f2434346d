//! The winch behind a simulated drive: its set-points move it, its sensors are what the drive shows.

use sinew::drive::{DriveCommand, DriveFault, DriveParameters};
use sinew::machine::DriveDevice;
use sinew::twin::arm::ArmTwin;
use sinew_segment::{AxisCommand, Drive};

/// Error code of a drive whose encoder gives no position, CiA 402: incremental sensor 1.
const ENCODER_FAULT: u16 = 0x7305;
/// Error code of a drive whose winding is too hot.
const MOTOR_HOT: u16 = 0x4310;
/// Error code of a drive whose winch is at the end of its drum: positive or negative limit switch.
const DRUM_END: u16 = 0x8611;
/// Speed with which a drive approaches a position, per s.
const POSITION_GAIN: f64 = 20.0;

/// A drive of a simulated machine: what it does for it, and the parameters of the design, from which it was
/// configured.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub(crate) drive: DriveDevice,
    pub(crate) parameters: DriveParameters,
}

impl Axis {
    /// The set-point of the drive in SI units.
    pub(crate) fn command(&self, arm: &ArmTwin, drive: &Drive) -> DriveCommand {
        let Self { drive: device, parameters } = self;
        if !drive.brake_released() {
            return DriveCommand::Brake;
        }
        let angle = self.motor_angle(arm);
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, angle);
        let per_count = core::f64::consts::TAU / device.counts_per_turn;
        match drive.command() {
            AxisCommand::Off => DriveCommand::Off,
            AxisCommand::QuickStop => DriveCommand::Velocity(0.0),
            AxisCommand::Velocity(counts) => {
                DriveCommand::Velocity(f64::from(counts) * per_count * per_radian)
            }
            AxisCommand::Position(counts) => {
                let ahead = device.angle(f64::from(counts)) - angle;
                DriveCommand::Velocity(POSITION_GAIN * ahead * per_radian)
            }
            AxisCommand::Torque(per_mille) => {
                let torque =
                    1e-3 * f64::from(per_mille) * device.rated_torque * device.counts_per_turn.signum();
                DriveCommand::Current(torque / parameters.motor.torque_constant)
            }
        }
    }

    /// Angle of the motor by its encoder, rad; NaN where the encoder gives none.
    fn motor_angle(&self, arm: &ArmTwin) -> f64 {
        let muscle = self.drive.muscle;
        let built = &arm.specimen().drives[muscle];
        built.winch.angle(arm.reading().motor[muscle]) * built.reducer.ratio
    }

    /// What is measured, and what is wrong with the winch.
    pub(crate) fn show(&self, arm: &ArmTwin, drive: &mut Drive) {
        let Self { drive: device, parameters } = self;
        let angle = self.motor_angle(arm);
        if !angle.is_finite() {
            drive.raise_fault(ENCODER_FAULT);
            return;
        }
        let step = &arm.truth().drives[device.muscle];
        match step.fault {
            Some(DriveFault::Hot { .. }) => drive.raise_fault(MOTOR_HOT),
            Some(DriveFault::DrumFull | DriveFault::DrumEmpty) => drive.raise_fault(DRUM_END),
            None => {}
        }
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, angle);
        let per_turn = device.counts_per_turn / core::f64::consts::TAU;
        let torque = parameters.motor.torque_constant * arm.reading().current[device.muscle];
        let per_mille = 1000.0 * torque / device.rated_torque * device.counts_per_turn.signum();
        drive.set_actual(
            device.counts(angle).round() as i32,
            (step.speed / per_radian * per_turn).round() as i32,
            per_mille.round() as i16,
        );
    }
}
