use super::muscle::MuscleDesign;
use crate::Error;
use crate::body::Robot;
use crate::drive::{DriveParameters, JointEncoder, Winch};
use crate::error::{finite, positive, within};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

/// A device of the machine. What identifies it is known to the room that drives its bus.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// As messages name it.
    pub name: String,
    /// What it does for the machine.
    pub role: DeviceRole,
}

/// What a device does for the machine.
#[derive(Debug, Clone, PartialEq)]
pub enum DeviceRole {
    /// The drive of a muscle.
    Drive(DriveDevice),
    /// Sensors, or none: a coupler.
    Sensors(Vec<SensorChannel>),
}

/// The drive of a muscle as a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveDevice {
    /// Index of the muscle.
    pub muscle: usize,
    /// What it is commanded.
    pub mode: DriveMode,
    /// Counts of the position per turn of the motor; negative where it counts up while the cable is paid out.
    pub counts_per_turn: f64,
    /// Angle of the motor at count 0, rad: that of an empty drum is 0.
    pub offset: f64,
    /// Torque of 1000 per mille, Nm, > 0.
    pub rated_torque: f64,
}

/// Commanded quantity of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DriveMode {
    /// A speed: the drive closes the velocity loop.
    #[default]
    Velocity,
    /// A torque: the control cycle closes it.
    Torque,
}

/// A sensor of a device.
///
/// ```text
/// reading = scale * count + offset
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorChannel {
    /// What it measures.
    pub signal: Signal,
    /// N, rad or m per count, not 0.
    pub scale: f64,
    /// N, rad or m.
    pub offset: f64,
}

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Tension at the drive of a muscle.
    Tension(usize),
    /// Coordinate of an independent joint.
    Joint(usize),
}

/// Joint encoders of one device, at most.
const MAX_CHANNELS: usize = 32;
/// Counts over the range of a load cell: 23 bits and a sign.
const LOAD_CELL_COUNTS: f64 = 8_388_608.0;

impl Device {
    /// The devices of a machine whose file names none: in the order of the muscles a drive and its load cell,
    /// where there is one, then the joint encoders.
    #[must_use]
    pub fn defaults(robot: &Robot, muscles: &[MuscleDesign], encoders: &[Option<JointEncoder>]) -> Vec<Self> {
        let channel = |signal, scale| SensorChannel { signal, scale, offset: 0.0 };
        let mut devices = Vec::new();
        for (k, (muscle, tendon)) in muscles.iter().zip(&robot.parts().tendons).enumerate() {
            let role = DeviceRole::Drive(DriveDevice::new(k, &muscle.drive));
            devices.push(Self { name: format!("drive of {}", tendon.name), role });
            if muscle.drive.has_load_cell {
                let scale = muscle.drive.load_cell.range / LOAD_CELL_COUNTS;
                let role = DeviceRole::Sensors(vec![channel(Signal::Tension(k), scale)]);
                devices.push(Self { name: format!("load cell of {}", tendon.name), role });
            }
        }
        let encoders: Vec<SensorChannel> = encoders
            .iter()
            .enumerate()
            .filter_map(|(joint, encoder)| Some(channel(Signal::Joint(joint), encoder.as_ref()?.resolution)))
            .collect();
        for (group, channels) in encoders.chunks(MAX_CHANNELS).enumerate() {
            let name =
                if group == 0 { "joint encoders".into() } else { format!("joint encoders {}", group + 1) };
            devices.push(Self { name, role: DeviceRole::Sensors(channels.to_vec()) });
        }
        devices
    }

    /// The muscle that it drives, where it is a drive.
    #[must_use]
    pub fn driven_muscle(&self) -> Option<usize> {
        match &self.role {
            DeviceRole::Drive(drive) => Some(drive.muscle),
            DeviceRole::Sensors(_) => None,
        }
    }

    /// Its sensors.
    #[must_use]
    pub fn channels(&self) -> &[SensorChannel] {
        match &self.role {
            DeviceRole::Drive(_) => &[],
            DeviceRole::Sensors(channels) => channels,
        }
    }
}

impl DriveDevice {
    /// The default: a drive whose position counts are those of its motor's encoder, rated for its continuous
    /// current.
    #[must_use]
    pub fn new(muscle: usize, drive: &DriveParameters) -> Self {
        Self {
            muscle,
            mode: DriveMode::default(),
            counts_per_turn: drive.encoder.counts,
            offset: 0.0,
            rated_torque: drive.motor.torque_constant * drive.motor.continuous_current,
        }
    }

    /// Angle of the motor at a position, counts, rad.
    #[must_use]
    pub fn angle(&self, counts: f64) -> f64 {
        counts * (TURN / self.counts_per_turn) + self.offset
    }

    /// Position of the motor at an angle, rad, in counts.
    #[must_use]
    pub fn counts(&self, angle: f64) -> f64 {
        (angle - self.offset) * (self.counts_per_turn / TURN)
    }

    /// Cable on the drum at an angle of the motor, rad, and its change with that angle: m and m/rad.
    #[must_use]
    pub fn cable(winch: &Winch, ratio: f64, angle: f64) -> [f64; 2] {
        let drum = angle / ratio;
        [winch.wound(drum), winch.arm(winch.layer(drum)) / ratio]
    }
}

const TURN: f64 = 2.0 * core::f64::consts::PI;

/// Checks the devices of a machine: every muscle has one drive, no signal is measured twice.
///
/// # Errors
/// [`Error::OutOfDomain`] names the number outside its domain.
pub(super) fn validate(devices: &[Device], muscles: usize, joints: usize) -> Result<(), Error> {
    let mut drives = vec![0_u32; muscles];
    let mut signals = Vec::new();
    for device in devices {
        match &device.role {
            DeviceRole::Drive(drive) => {
                let muscle = drive.muscle;
                within("muscle of a device", "an index of a muscle", muscle as f64, muscle < muscles)?;
                drives[muscle] += 1;
                finite("counts_per_turn", drive.counts_per_turn)?;
                within("counts_per_turn", "not 0", drive.counts_per_turn, drive.counts_per_turn != 0.0)?;
                finite("offset_rad", drive.offset)?;
                positive("rated_torque_nm", drive.rated_torque)?;
            }
            DeviceRole::Sensors(channels) => {
                for channel in channels {
                    let (index, count) = match channel.signal {
                        Signal::Tension(muscle) => (muscle, muscles),
                        Signal::Joint(joint) => (joint, joints),
                    };
                    within(
                        "signal of a channel",
                        "an index of a muscle or a joint",
                        index as f64,
                        index < count,
                    )?;
                    let once = !signals.contains(&channel.signal);
                    within("signal of a channel", "measured by one channel", index as f64, once)?;
                    signals.push(channel.signal);
                    finite("scale", channel.scale)?;
                    within("scale", "not 0", channel.scale, channel.scale != 0.0)?;
                    finite("offset", channel.offset)?;
                }
            }
        }
    }
    let alone = drives.iter().position(|count| *count != 1);
    alone.map_or(Ok(()), |muscle| {
        let count = f64::from(drives[muscle]);
        within("drives of a muscle among the devices", "exactly one", count, false).map(drop)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_angles_are_inverse_in_both_directions_of_counting() {
        for counts_per_turn in [2048.0, -131_072.0] {
            let drive = DriveDevice {
                muscle: 0,
                mode: DriveMode::Velocity,
                counts_per_turn,
                offset: 12.5,
                rated_torque: 0.1,
            };
            for angle in [-100.0, 0.0, 12.5, 400.0] {
                assert!((drive.angle(drive.counts(angle)) - angle).abs() < 1e-9);
            }
        }
    }
}
