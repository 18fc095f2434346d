//! The simulated machine behind simulated devices: their set-points move it, its sensors fill their inputs.

use super::device::{ChannelObjects, EthercatDevice};
use crate::cia402::{Axis, ObjectAddress};
use sinew::drive::{DriveCommand, DriveParameters};
use sinew::machine::{DeviceRole, DriveDevice, Machine, SensorChannel, Signal};
use sinew::twin::arm::ArmTwin;
use sinew_segment::{DescriptionError, DescriptionFile, DeviceDescription, DeviceSettings, Segment, builtin};

/// A machine as built, with the devices of its fieldbus.
#[derive(Debug, Clone)]
pub struct SimulatedMachine {
    arm: ArmTwin,
    devices: Vec<EthercatDevice>,
    /// Of the design, from which the drives were configured: `[muscles]`.
    drives: Vec<DriveParameters>,
    commands: Vec<DriveCommand>,
    started: bool,
    failed: bool,
}

impl SimulatedMachine {
    /// A machine as built; `machine` is its design, whose `devices` stand on the wire in their order.
    #[must_use]
    pub fn new(arm: ArmTwin, machine: &Machine, devices: Vec<EthercatDevice>) -> Self {
        Self {
            devices,
            drives: machine.muscles.iter().map(|muscle| muscle.drive).collect(),
            commands: vec![DriveCommand::Brake; machine.muscles.len()],
            started: false,
            failed: false,
            arm,
        }
    }

    /// The segment with the devices of this machine: the latest revision that the files describe and the
    /// machine file accepts, and devices of this program under the identity of those that no file describes.
    ///
    /// # Errors
    /// The first field of a description that cannot be used or contradicts itself.
    pub fn segment(&self, descriptions: &[DescriptionFile]) -> Result<Segment, DescriptionError> {
        let mut devices = Vec::new();
        for (place, device) in self.devices.iter().enumerate() {
            let description = described(descriptions, device)?.unwrap_or_else(|| stand_in(device));
            let settings = DeviceSettings {
                alias: device.alias.unwrap_or(0),
                drift_ppb: clock_drift(place),
                ..DeviceSettings::default()
            };
            devices.push(sinew_segment::Device::new(&description, settings)?);
        }
        let mut segment = Segment::new(devices);
        self.show(&mut segment);
        Ok(segment)
    }

    /// The machine.
    #[must_use]
    pub fn arm(&self) -> &ArmTwin {
        &self.arm
    }

    /// Whether it moved faster than the laws of its cables allow; it stands since.
    #[must_use]
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The machine follows the set-points of its drives for a period, ns, and shows its measurements.
    pub fn advance(&mut self, segment: &mut Segment, period: u64) {
        for (place, device) in self.devices.iter().enumerate() {
            let DeviceRole::Drive(drive) = &device.device.role else { continue };
            let Some(axis) = segment.device(place).and_then(|device| device.drive()) else { continue };
            self.started |= axis.brake_released();
            self.commands[drive.muscle] = self.axis(drive).command(&self.arm, axis);
        }
        if self.started && !self.failed {
            self.failed = self.arm.step(&self.commands, period as f64 * 1e-9).is_err();
        }
        self.show(segment);
    }

    /// The winch of a drive.
    fn axis(&self, drive: &DriveDevice) -> Axis {
        Axis { drive: *drive, parameters: self.drives[drive.muscle] }
    }

    /// All measurements as counts.
    fn show(&self, segment: &mut Segment) {
        for (place, device) in self.devices.iter().enumerate() {
            let Some(simulated) = segment.device_mut(place) else { continue };
            match &device.device.role {
                DeviceRole::Drive(drive) => {
                    let Some(axis) = simulated.drive_mut() else { continue };
                    self.axis(drive).show(&self.arm, axis);
                }
                DeviceRole::Sensors(_) => {
                    for (channel, objects) in device.channels() {
                        show_channel((channel, objects), self.reading(channel), simulated);
                    }
                }
            }
        }
    }

    /// What a sensor measures, N, rad or m.
    fn reading(&self, channel: &SensorChannel) -> f64 {
        let reading = self.arm.reading();
        match channel.signal {
            Signal::Tension(muscle) => reading.tension[muscle],
            Signal::Joint(joint) => reading.joint[joint],
        }
    }
}

/// A reading as a count with a clear status, or a status that marks it as invalid.
fn show_channel(
    (channel, objects): (&SensorChannel, &ChannelObjects),
    reading: f64,
    device: &mut sinew_segment::Device,
) {
    let mut set =
        |object: ObjectAddress, octets: &[u8]| device.set_object(object.index, object.subindex, octets);
    if let Some((object, mask)) = objects.status {
        set(object, &(if reading.is_finite() { 0 } else { mask }).to_le_bytes());
    }
    if reading.is_finite() {
        let count = ((reading - channel.offset) / channel.scale).round();
        set(objects.value, &(count as i32).to_le_bytes());
    }
}

/// The description of a device, of the latest revision that is accepted, where a file has one.
fn described(
    files: &[DescriptionFile],
    device: &EthercatDevice,
) -> Result<Option<DeviceDescription>, DescriptionError> {
    let all = files.iter().flat_map(|file| file.identities().iter().map(move |of| (of, file)));
    let accepted = all.filter(|(of, _)| device.identity.accepts([of.vendor, of.product, of.revision]));
    let latest = accepted.max_by_key(|(of, _)| of.revision);
    latest.map(|(of, file)| file.describe(of.product, of.revision)).transpose()
}

/// A simulated device in the place of one that is not described: the built-in drive, or a terminal with its
/// channels, under its identity.
fn stand_in(device: &EthercatDevice) -> DeviceDescription {
    let mut description = match &device.device.role {
        DeviceRole::Drive(_) => builtin::drive(),
        DeviceRole::Sensors(channels) => match channels.as_slice() {
            [] => builtin::coupler(),
            [one] if matches!(one.signal, Signal::Tension(_)) => builtin::load_cell(),
            _ => builtin::encoder(terminal_channels(&device.objects)),
        },
    };
    let identity = device.identity;
    description.identity.vendor = identity.vendor;
    description.identity.product = identity.product;
    description.identity.revision = identity.revision;
    description
}

/// Drift of a device's clock, ppb: within 20 ppm, as quartz has it.
fn clock_drift(place: usize) -> i32 {
    1000 * ((7 * place + 31) % 41) as i32 - 20_000
}

/// Channels that a terminal needs so that it has every value that is read: their records begin at 0x6000, 16
/// apart.
fn terminal_channels(channels: &[ChannelObjects]) -> usize {
    let place = |channel: &ChannelObjects| usize::from(channel.value.index.saturating_sub(0x6000) / 0x10) + 1;
    channels.iter().map(place).max().unwrap_or(0)
}
