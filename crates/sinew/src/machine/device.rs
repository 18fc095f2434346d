use super::muscle::MuscleDesign;
use crate::Error;
use crate::body::Robot;
use crate::drive::{DriveParameters, JointEncoder, Winch};
use crate::error::{finite, positive, within};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

/// A device on the machine's fieldbus.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// As messages name it.
    pub name: String,
    /// What has to answer at its place.
    pub identity: DeviceIdentity,
    /// Station alias that it has; without one it is identified by its place on the wire.
    pub alias: Option<u16>,
    /// What it does for the machine.
    pub role: DeviceRole,
}

/// Identity of a device, as in its EEPROM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceIdentity {
    /// Vendor ID.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision number.
    pub revision: u32,
    /// Which revisions can take its place.
    pub rule: RevisionRule,
}

/// Which revisions of a device are accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RevisionRule {
    /// The same.
    Exact,
    /// The same or a later one.
    AtLeast,
    /// Every one.
    Any,
}

impl DeviceIdentity {
    /// Whether a device with this vendor ID, product code and revision number is accepted.
    #[must_use]
    pub fn accepts(&self, [vendor, product, revision]: [u32; 3]) -> bool {
        let fits = match self.rule {
            RevisionRule::Exact => revision == self.revision,
            RevisionRule::AtLeast => revision >= self.revision,
            RevisionRule::Any => true,
        };
        vendor == self.vendor && product == self.product && fits
    }
}

/// What a device does for the machine.
#[derive(Debug, Clone, PartialEq)]
pub enum DeviceRole {
    /// The drive of a muscle (CiA 402).
    Drive(DriveDevice),
    /// Sensors, or none: a coupler.
    Sensors(Vec<SensorChannel>),
}

/// The drive of a muscle on the fieldbus.
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
    /// Whether a drive with a distributed clock takes its set-points over at SYNC0, once a period, or as they arrive.
    pub sync0: bool,
}

/// Commanded quantity of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DriveMode {
    /// Cyclic synchronous velocity: the drive closes the velocity loop.
    #[default]
    Velocity,
    /// Cyclic synchronous torque: the control cycle closes it.
    Torque,
}

/// A sensor on the fieldbus.
///
/// ```text
/// reading = scale * count + offset
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorChannel {
    /// What it measures.
    pub signal: Signal,
    /// Object of the count in the device's process data.
    pub value: ObjectAddress,
    /// Object of a status word and the bits of it that mark a reading as invalid.
    pub status: Option<(ObjectAddress, u16)>,
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

/// Place of an entry in a device's object dictionary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ObjectAddress {
    /// Index.
    pub index: u16,
    /// Subindex.
    pub subindex: u8,
}

/// Vendor ID of the simulated devices.
const SIMULATED_VENDOR: u32 = 0x0005_1e37;
/// Product codes of the simulated drive, load-cell terminal and encoder terminal with no channel, and their revision.
const SIMULATED_DRIVE: u32 = 0x0001_0402;
const SIMULATED_LOAD_CELL: u32 = 0x0002_0001;
const SIMULATED_ENCODERS: u32 = 0x0003_0000;
const SIMULATED_REVISION: u32 = 0x0001_0000;
/// Channels of an encoder terminal, at most.
const MAX_CHANNELS: usize = 32;
/// Counts over the range of a load cell: 23 bits and a sign.
const LOAD_CELL_COUNTS: f64 = 8_388_608.0;

impl Device {
    /// The devices of a machine whose file names none: in the order of the muscles a drive and a terminal with its load
    /// cell, then terminals with the joint encoders. They are the simulated devices of this project.
    #[must_use]
    pub fn defaults(robot: &Robot, muscles: &[MuscleDesign], encoders: &[Option<JointEncoder>]) -> Vec<Self> {
        let identity = |product| DeviceIdentity {
            vendor: SIMULATED_VENDOR,
            product,
            revision: SIMULATED_REVISION,
            rule: RevisionRule::AtLeast,
        };
        let device = |name, product, role| Self { name, identity: identity(product), alias: None, role };
        let mut devices = Vec::new();
        for (k, (muscle, tendon)) in muscles.iter().zip(&robot.parts().tendons).enumerate() {
            let drive = DeviceRole::Drive(DriveDevice::of(k, &muscle.drive));
            devices.push(device(format!("drive of {}", tendon.name), SIMULATED_DRIVE, drive));
            let scale = muscle.drive.load_cell.range / LOAD_CELL_COUNTS;
            let cell = DeviceRole::Sensors(vec![SensorChannel::simulated(Signal::Tension(k), 0, scale)]);
            devices.push(device(format!("load cell of {}", tendon.name), SIMULATED_LOAD_CELL, cell));
        }
        let encoders: Vec<(usize, JointEncoder)> =
            encoders.iter().enumerate().filter_map(|(k, encoder)| Some((k, (*encoder)?))).collect();
        for (group, channels) in encoders.chunks(MAX_CHANNELS).enumerate() {
            let channel = |(place, (joint, encoder)): (usize, &(usize, JointEncoder))| {
                SensorChannel::simulated(Signal::Joint(*joint), place as u16, encoder.resolution)
            };
            let role = DeviceRole::Sensors(channels.iter().enumerate().map(channel).collect());
            let name =
                if group == 0 { "joint encoders".into() } else { format!("joint encoders {}", group + 1) };
            devices.push(device(name, SIMULATED_ENCODERS + channels.len() as u32, role));
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
    /// The default: a drive whose position counts are those of its motor's encoder, rated for its continuous current.
    #[must_use]
    pub fn of(muscle: usize, drive: &DriveParameters) -> Self {
        Self {
            muscle,
            mode: DriveMode::default(),
            counts_per_turn: drive.encoder.counts,
            offset: 0.0,
            rated_torque: drive.motor.torque_constant * drive.motor.continuous_current,
            sync0: true,
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

impl SensorChannel {
    /// A channel of a simulated terminal: its records begin at 0x6000 and are 16 apart, status and count.
    fn simulated(signal: Signal, place: u16, scale: f64) -> Self {
        let index = 0x6000 + 0x10 * place;
        Self {
            signal,
            value: ObjectAddress { index, subindex: 2 },
            status: Some((ObjectAddress { index, subindex: 1 }, u16::MAX)),
            scale,
            offset: 0.0,
        }
    }
}

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
                sync0: true,
            };
            for angle in [-100.0, 0.0, 12.5, 400.0] {
                assert!((drive.angle(drive.counts(angle)) - angle).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_revision_is_accepted_by_its_rule() {
        let of = |rule| DeviceIdentity { vendor: 1, product: 2, revision: 3, rule };
        for (rule, accepted) in [
            (RevisionRule::Exact, [false, true, false]),
            (RevisionRule::AtLeast, [false, true, true]),
            (RevisionRule::Any, [true; 3]),
        ] {
            assert_eq!([2, 3, 4].map(|revision| of(rule).accepts([1, 2, revision])), accepted);
            assert!(!of(rule).accepts([1, 9, 3]) && !of(rule).accepts([9, 2, 3]));
        }
    }
}
