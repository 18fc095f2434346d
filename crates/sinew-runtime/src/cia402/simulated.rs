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

/// What is wrong with a winch, as its drive notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WinchFault {
    /// Its encoder gives no position.
    Encoder,
    /// Its winding is too hot.
    Hot,
    /// It is at the end of its drum.
    DrumEnd,
}

/// What a drive measures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measured {
    /// Counts, NaN without an encoder, and counts/s.
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    /// Current of the motor, A, in the direction of the counts.
    pub(crate) current: f64,
}

impl Axis {
    /// The set-point of a drive after CiA 402 in SI units.
    pub(crate) fn command(&self, arm: &ArmTwin, drive: &Drive) -> DriveCommand {
        let Self { drive: device, parameters } = self;
        if !drive.brake_released() {
            return DriveCommand::Brake;
        }
        match drive.command() {
            AxisCommand::Off => DriveCommand::Off,
            AxisCommand::QuickStop => DriveCommand::Velocity(0.0),
            AxisCommand::Velocity(counts) => self.velocity(arm, f64::from(counts)),
            AxisCommand::Position(counts) => {
                let angle = self.motor_angle(arm);
                let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, angle);
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

    /// A velocity of the motor, counts/s, at the cable.
    pub(crate) fn velocity(&self, arm: &ArmTwin, counts: f64) -> DriveCommand {
        let Self { drive: device, parameters } = self;
        let [_, per_radian] =
            DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, self.motor_angle(arm));
        DriveCommand::Velocity(counts * (core::f64::consts::TAU / device.counts_per_turn) * per_radian)
    }

    /// The command of a drive whose motor shall follow a velocity in its counts or turns per second; a brake
    /// holds the winch of one without power.
    pub(crate) fn turns(&self, arm: &ArmTwin, turns: Option<f32>) -> DriveCommand {
        turns.map_or(DriveCommand::Brake, |turns| self.velocity(arm, f64::from(turns)))
    }

    /// Angle of the motor by its encoder, rad; NaN where the encoder gives none.
    fn motor_angle(&self, arm: &ArmTwin) -> f64 {
        let muscle = self.drive.muscle;
        let built = &arm.specimen().drives[muscle];
        built.winch.angle(arm.reading().motor[muscle]) * built.reducer.ratio
    }

    /// What is wrong with the winch.
    pub(crate) fn fault(&self, arm: &ArmTwin) -> Option<WinchFault> {
        if !self.motor_angle(arm).is_finite() {
            return Some(WinchFault::Encoder);
        }
        Some(match arm.truth().drives[self.drive.muscle].fault? {
            DriveFault::Hot { .. } => WinchFault::Hot,
            DriveFault::DrumFull | DriveFault::DrumEmpty => WinchFault::DrumEnd,
        })
    }

    /// What the drive measures.
    pub(crate) fn measured(&self, arm: &ArmTwin) -> Measured {
        let Self { drive: device, parameters } = self;
        let angle = self.motor_angle(arm);
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, angle);
        let per_turn = device.counts_per_turn / core::f64::consts::TAU;
        Measured {
            position: device.counts(angle),
            velocity: arm.truth().drives[device.muscle].speed / per_radian * per_turn,
            current: arm.reading().current[device.muscle] * device.counts_per_turn.signum(),
        }
    }

    /// What a drive after CiA 402 measures and notices.
    pub(crate) fn show(&self, arm: &ArmTwin, drive: &mut Drive) {
        match self.fault(arm) {
            Some(WinchFault::Encoder) => {
                drive.raise_fault(ENCODER_FAULT);
                return;
            }
            Some(WinchFault::Hot) => drive.raise_fault(MOTOR_HOT),
            Some(WinchFault::DrumEnd) => drive.raise_fault(DRUM_END),
            None => {}
        }
        let Measured { position, velocity, current } = self.measured(arm);
        let torque = self.parameters.motor.torque_constant * current;
        let per_mille = 1000.0 * torque / self.drive.rated_torque;
        drive.set_actual(position.round() as i32, velocity.round() as i32, per_mille.round() as i16);
    }
}
