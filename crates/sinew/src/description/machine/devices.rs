//! Devices on the fieldbus, in the order on the wire.

use super::listing::{Listing, Value, ValueSource, source_of};
use crate::description::document::{Entry, Table};
use crate::description::domain::{FINITE, NOT_ZERO, POSITIVE, STATION_ALIAS, UNSIGNED_16, UNSIGNED_32};
use crate::description::error::DescriptionError;
use crate::machine::{
    Device, DeviceIdentity, DeviceRole, DriveDevice, DriveMode, Machine, ObjectAddress, RevisionRule,
    SensorChannel, Signal,
};
use alloc::format;
use alloc::vec::Vec;

/// Keys of `[[device]]`.
pub(super) const DEVICE: [&str; 13] = [
    "name",
    "vendor",
    "product",
    "revision",
    "revision_rule",
    "alias",
    "muscle",
    "mode",
    "counts_per_turn",
    "offset_rad",
    "rated_torque_nm",
    "synchronization",
    "channel",
];
/// Those of drives alone.
const DRIVE: [&str; 5] = ["mode", "counts_per_turn", "offset_rad", "rated_torque_nm", "synchronization"];
/// Keys of `[[device.channel]]`.
pub(super) const CHANNEL: [&str; 7] = ["name", "muscle", "joint", "value", "status", "scale", "offset"];

const MODES: [&str; 2] = ["velocity", "torque"];
const SYNCHRONIZATIONS: [&str; 2] = ["sync0", "frame"];
const RULES: [&str; 3] = ["exact", "at_least", "any"];

/// The devices of a machine; those of [`Device::defaults`] where the file names none.
pub(super) fn read(
    root: &Table<'_>,
    machine: &Machine,
    listing: &mut Listing,
) -> Result<Vec<Device>, DescriptionError> {
    let tables = root.tables("device", "name", &DEVICE)?;
    if tables.is_empty() {
        return Ok(Device::defaults(&machine.robot, &machine.muscles, &machine.encoders));
    }
    let mut devices = Vec::new();
    for (table, named) in tables {
        listing.begin(&table.place);
        let device = Device {
            name: named.text,
            identity: identity(&table, listing)?,
            alias: table
                .entry("alias")
                .map(|entry| entry.number(STATION_ALIAS))
                .transpose()?
                .map(|x| x as u16),
            role: role(&table, machine, listing)?,
        };
        refuse_twice(&table, &devices, &device)?;
        devices.push(device);
    }
    let driven = |muscle: usize| devices.iter().any(|device| device.driven_muscle() == Some(muscle));
    match muscles(machine).iter().enumerate().find(|(muscle, _)| !driven(*muscle)) {
        Some((_, name)) => Err(root.error(&format!("no [[device]] is the drive of muscle `{name}`"))),
        None => Ok(devices),
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

fn identity(table: &Table<'_>, listing: &mut Listing) -> Result<DeviceIdentity, DescriptionError> {
    let mut number = |key: &str| -> Result<u32, DescriptionError> {
        let entry = table.required(key)?;
        let number = entry.number(UNSIGNED_32)?;
        listing.number(key, number, ValueSource::File { line: entry.line() });
        Ok(number as u32)
    };
    let (vendor, product) = (number("vendor")?, number("product")?);
    let revision = if table.entry("revision").is_some() { number("revision")? } else { 0 };
    let rule = table.entry("revision_rule");
    let chosen = rule.as_ref().map_or(Ok(1), |entry| entry.name("revision_rule", &RULES))?;
    listing.text("revision_rule", RULES[chosen], source_of(rule.map(|entry| entry.line())));
    let rule = [RevisionRule::Exact, RevisionRule::AtLeast, RevisionRule::Any][chosen];
    Ok(DeviceIdentity { vendor, product, revision, rule })
}

fn role(table: &Table<'_>, machine: &Machine, listing: &mut Listing) -> Result<DeviceRole, DescriptionError> {
    let Some(muscle) = table.entry("muscle") else {
        if let Some(entry) = DRIVE.iter().find_map(|key| table.entry(key)) {
            return Err(entry.problem(", but the device is no drive: expected the key `muscle` beside it"));
        }
        return channels(table, machine, listing).map(DeviceRole::Sensors);
    };
    if let Some(entry) = table.entry("channel") {
        return Err(entry.bare("a drive has no channels: expected the load cell in a device of its own"));
    }
    let index = muscle.name("muscle", &muscles(machine))?;
    let mut drive = DriveDevice::of(index, &machine.muscles[index].drive);
    let mode = table.entry("mode");
    let chosen = mode.as_ref().map_or(Ok(0), |entry| entry.name("mode", &MODES))?;
    drive.mode = [DriveMode::Velocity, DriveMode::Torque][chosen];
    listing.text("mode", MODES[chosen], source_of(mode.map(|entry| entry.line())));
    let synchronization = table.entry("synchronization");
    let chosen =
        synchronization.as_ref().map_or(Ok(0), |entry| entry.name("synchronization", &SYNCHRONIZATIONS))?;
    drive.sync0 = chosen == 0;
    let source = source_of(synchronization.map(|entry| entry.line()));
    listing.text("synchronization", SYNCHRONIZATIONS[chosen], source);
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
    Ok(DeviceRole::Drive(drive))
}

fn channels(
    table: &Table<'_>,
    machine: &Machine,
    listing: &mut Listing,
) -> Result<Vec<SensorChannel>, DescriptionError> {
    let channel = |(table, _): (Table<'_>, _)| {
        let signal = signal(&table, machine)?;
        let value = address(&table.required("value")?)?;
        let status = table.table("status")?.map(|status| -> Result<_, DescriptionError> {
            status.check_keys(&["object", "error_mask"])?;
            let mask = status.entry("error_mask").map(|entry| entry.number(UNSIGNED_16)).transpose()?;
            Ok((address(&status.required("object")?)?, mask.map_or(u16::MAX, |mask| mask as u16)))
        });
        let scale = table.required("scale")?.number(NOT_ZERO)?;
        let offset = table.entry("offset").map_or(Ok(0.0), |entry| entry.number(FINITE))?;
        Ok(SensorChannel { signal, value, status: status.transpose()?, scale, offset })
    };
    let tables = table.tables("channel", "name", &CHANNEL)?;
    let names = tables.iter().map(|(_, named)| named.text.clone()).collect();
    let line = table.entry("channel").map(|entry| entry.line());
    let read: Result<Vec<_>, DescriptionError> = tables.into_iter().map(channel).collect();
    listing.add("channel", Value::Texts(names), source_of(line));
    read
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

/// An index and a subindex: `[0x6000, 2]`.
fn address(entry: &Entry<'_>) -> Result<ObjectAddress, DescriptionError> {
    let [index, subindex] = entry.numbers::<2>(UNSIGNED_16)?;
    if subindex > f64::from(u8::MAX) {
        return Err(entry.refuse("index and subindex of an object, the latter in 0..=0xff"));
    }
    Ok(ObjectAddress { index: index as u16, subindex: subindex as u8 })
}
