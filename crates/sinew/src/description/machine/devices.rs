//! Devices of a machine: what they do for it. What identifies them is read by the room that drives their bus.

use super::listing::{Listing, Value, source_of};
use crate::description::document::Table;
use crate::description::domain::{FINITE, NOT_ZERO, POSITIVE};
use crate::description::error::DescriptionError;
use crate::machine::{Device, DeviceRole, DriveDevice, DriveMode, Machine, SensorChannel, Signal};
use alloc::format;
use alloc::vec::Vec;

/// Keys that drives alone have.
const DRIVE: [&str; 4] = ["mode", "counts_per_turn", "offset_rad", "rated_torque_nm"];

const MODES: [&str; 2] = ["velocity", "torque"];

/// What the tables of devices say for the bus that they are on, beside their roles.
pub trait BusReader {
    /// Its keys.
    fn keys(&self) -> BusKeys;

    /// Reads their values: of one device after the other, in the order of the file.
    ///
    /// # Errors
    /// The first value that it cannot use.
    fn read(
        &mut self,
        device: &Table<'_>,
        channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError>;
}

/// Keys of a bus.
#[derive(Debug, Clone, Default)]
pub struct BusKeys {
    /// In `[[device]]`.
    pub device: Vec<&'static str>,
    /// In `[[device]]` of drives alone.
    pub drive: Vec<&'static str>,
    /// In `[[device.channel]]`.
    pub channel: Vec<&'static str>,
}

/// The reader of the bus, where there is one: without it, keys that are none of a role are left out.
pub(super) type Bus<'a> = Option<&'a mut dyn BusReader>;

/// The devices of a machine; those of [`Device::defaults`] where the file names none.
pub(super) fn read(
    root: &Table<'_>,
    machine: &Machine,
    bus: &mut Bus<'_>,
    listing: &mut Listing,
) -> Result<Vec<Device>, DescriptionError> {
    let keys = bus.as_ref().map(|bus| Keys::with(&bus.keys()));
    let known = keys.as_ref();
    let tables = root.tables_with("device", "name", known.map(|keys| &keys.device[..]))?;
    if tables.is_empty() {
        return Ok(Device::defaults(&machine.robot, &machine.muscles, &machine.encoders));
    }
    let mut devices = Vec::new();
    for (table, named) in tables {
        listing.begin(&table.place);
        let channels = table.tables_with("channel", "name", known.map(|keys| &keys.channel[..]))?;
        let names = channels.iter().map(|(_, named)| named.text.clone()).collect();
        let channels: Vec<_> = channels.into_iter().map(|(table, _)| table).collect();
        let drive_keys = known.map_or(&DRIVE[..], |keys| &keys.drive);
        if let (None, Some(entry)) =
            (table.entry("muscle"), drive_keys.iter().find_map(|key| table.entry(key)))
        {
            return Err(entry.problem(", but the device is no drive: expected the key `muscle` beside it"));
        }
        if let Some(bus) = bus {
            bus.read(&table, &channels, listing)?;
        }
        let role = if table.entry("muscle").is_some() {
            DeviceRole::Drive(drive(&table, machine, listing)?)
        } else {
            let line = table.entry("channel").map(|entry| entry.line());
            listing.add("channel", Value::Texts(names), source_of(line));
            let channels = channels.iter().map(|table| channel(table, machine));
            DeviceRole::Sensors(channels.collect::<Result<_, _>>()?)
        };
        let device = Device { name: named.text, role };
        refuse_twice(&table, &devices, &device)?;
        devices.push(device);
    }
    let driven = |muscle: usize| devices.iter().any(|device| device.driven_muscle() == Some(muscle));
    match muscles(machine).iter().enumerate().find(|(muscle, _)| !driven(*muscle)) {
        Some((_, name)) => Err(root.error(&format!("no [[device]] is the drive of muscle `{name}`"))),
        None => Ok(devices),
    }
}

/// All keys: of devices, of drives alone, of channels.
struct Keys {
    device: Vec<&'static str>,
    drive: Vec<&'static str>,
    channel: Vec<&'static str>,
}

impl Keys {
    fn with(bus: &BusKeys) -> Self {
        let drive = [&DRIVE, &bus.drive[..]].concat();
        Self {
            device: [&["name"], &bus.device[..], &["muscle"], &drive, &["channel"]].concat(),
            channel: [&["name", "muscle", "joint"], &bus.channel[..], &["scale", "offset"]].concat(),
            drive,
        }
    }
}

/// Refuses a device that drives or measures what another one does.
fn refuse_twice(table: &Table<'_>, devices: &[Device], device: &Device) -> Result<(), DescriptionError> {
    let drives =
        |other: &&Device| device.driven_muscle().is_some() && other.driven_muscle() == device.driven_muscle();
    if let (Some(other), Some(entry)) = (devices.iter().find(drives), table.entry("muscle")) {
        return Err(
            entry.problem(&format!(", but `{}` is its drive: expected one drive of a muscle", other.name))
        );
    }
    let channels = device.channels();
    for (k, channel) in channels.iter().enumerate() {
        let all = devices.iter().flat_map(Device::channels).chain(&channels[..k]);
        if all.into_iter().any(|other| other.signal == channel.signal) {
            let entry = table.required("channel")?;
            return Err(entry.bare("two channels measure the same: expected one of a muscle or a joint"));
        }
    }
    Ok(())
}

fn drive(
    table: &Table<'_>,
    machine: &Machine,
    listing: &mut Listing,
) -> Result<DriveDevice, DescriptionError> {
    if let Some(entry) = table.entry("channel") {
        return Err(entry.bare("a drive has no channels: expected the load cell in a device of its own"));
    }
    let index = table.required("muscle")?.name("muscle", &muscles(machine))?;
    let mut drive = DriveDevice::new(index, &machine.muscles[index].drive);
    let chosen = listing.word(table, "mode", (&MODES, 0))?;
    drive.mode = [DriveMode::Velocity, DriveMode::Torque][chosen];
    for (key, domain, number) in [
        ("counts_per_turn", NOT_ZERO, &mut drive.counts_per_turn),
        ("offset_rad", FINITE, &mut drive.offset),
        ("rated_torque_nm", POSITIVE, &mut drive.rated_torque),
    ] {
        let entry = table.entry(key);
        if let Some(entry) = &entry {
            *number = entry.number(domain)?;
        }
        listing.number(key, *number, source_of(entry.map(|entry| entry.line())));
    }
    Ok(drive)
}

fn channel(table: &Table<'_>, machine: &Machine) -> Result<SensorChannel, DescriptionError> {
    let signal = signal(table, machine)?;
    let scale = table.required("scale")?.number(NOT_ZERO)?;
    let offset = table.entry("offset").map_or(Ok(0.0), |entry| entry.number(FINITE))?;
    Ok(SensorChannel { signal, scale, offset })
}

fn signal(table: &Table<'_>, machine: &Machine) -> Result<Signal, DescriptionError> {
    match (table.entry("muscle"), table.entry("joint")) {
        (Some(muscle), None) => Ok(Signal::Tension(muscle.name("muscle", &muscles(machine))?)),
        (None, Some(joint)) => Ok(Signal::Joint(joint.name("joint", &joints(machine))?)),
        (Some(_), Some(joint)) => {
            Err(joint.problem(", but the channel measures a muscle's tension: expected one of both"))
        }
        (None, None) => Err(table.error("muscle or joint is missing: expected what the channel measures")),
    }
}

fn muscles(machine: &Machine) -> Vec<&str> {
    machine.robot.parts().tendons.iter().map(|tendon| tendon.name.as_str()).collect()
}

fn joints(machine: &Machine) -> Vec<&str> {
    let joints = &machine.robot.parts().joints;
    machine.robot.independent_joints().into_iter().map(|joint| joints[joint].name.as_str()).collect()
}
