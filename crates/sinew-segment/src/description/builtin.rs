//! Devices that come with the crate: a servo drive, a load-cell terminal, an encoder terminal, a coupler.

use super::{
    Access, ClockDescription, DataType, DeviceDescription, EntryDescription, FmmuUse, Identity, ObjectCode,
    ObjectDescription, PdoDescription, PdoEntry, PdoMappable, Profile, SyncManagerDescription,
    SyncManagerKind,
};

/// Vendor ID of all built-in devices: a number that no vendor of the EtherCAT Technology Group has.
pub const VENDOR: u32 = 0x0005_1e37;

/// Table of the servo drive; a beginning for other drives.
pub const DRIVE_TOML: &str = include_str!("../../devices/drive.toml");
/// Table of the load-cell terminal.
pub const LOAD_CELL_TOML: &str = include_str!("../../devices/load_cell.toml");

/// A servo drive after CiA 402 with cyclic synchronous position, velocity and torque.
#[must_use]
#[expect(clippy::expect_used, reason = "the table is part of the program and read in a test")]
pub fn drive() -> DeviceDescription {
    DeviceDescription::from_toml("drive.toml", DRIVE_TOML).expect("the built-in drive is valid")
}

/// A terminal with one load cell: status word and a signed 32-bit value.
#[must_use]
#[expect(clippy::expect_used, reason = "the table is part of the program and read in a test")]
pub fn load_cell() -> DeviceDescription {
    DeviceDescription::from_toml("load_cell.toml", LOAD_CELL_TOML).expect("the built-in load cell is valid")
}

/// A terminal with 1 to 32 encoders, each a 16-bit status and a signed 32-bit count. Simple: without a
/// mailbox.
#[must_use]
pub fn encoder(channels: usize) -> DeviceDescription {
    let channels = channels.clamp(1, 32) as u16;
    let entry = |subindex, name: &str, data_type, bits| EntryDescription {
        subindex,
        name: name.to_owned(),
        data_type,
        bits,
        access: Access::Read,
        pdo: PdoMappable::Inputs,
        value: Vec::new(),
        limits: None,
    };
    let index = |channel: u16| 0x6000 + 0x10 * channel;
    let objects = (0..channels).map(|channel| ObjectDescription {
        index: index(channel),
        name: format!("Encoder {}", channel + 1),
        code: ObjectCode::Record,
        entries: vec![
            EntryDescription::count(2),
            entry(1, "Status", DataType::U16, 16),
            entry(2, "Counter value", DataType::I32, 32),
        ],
    });
    let pdos = (0..channels).map(|channel| PdoDescription {
        index: 0x1a00 + channel,
        name: format!("Encoder {}", channel + 1),
        assigned: true,
        fixed: true,
        entries: [(1, 16), (2, 32)]
            .map(|(subindex, bits)| PdoEntry { index: index(channel), subindex, bits })
            .to_vec(),
    });
    DeviceDescription {
        origin: "encoder".to_owned(),
        identity: Identity {
            vendor: VENDOR,
            product: 0x0003_0000 + u32::from(channels),
            revision: 0x0001_0000,
            serial: 0,
        },
        name: format!("SIM-ENC{channels}"),
        title: format!("Simulated terminal for {channels} encoders"),
        group: "Simulated".to_owned(),
        profile: Profile::Plain,
        memory: 0x1000,
        sync_managers: vec![SyncManagerDescription {
            kind: SyncManagerKind::Inputs,
            start: 0x1000,
            length: 0,
            watchdog: false,
        }],
        fmmus: vec![FmmuUse::Inputs],
        mailbox: None,
        clock: Some(ClockDescription { sync: false, wide: true, min_cycle_ns: 0 }),
        objects: objects.collect(),
        pdos: pdos.collect(),
        channels: (0..channels).map(|channel| (index(channel), 2)).collect(),
    }
}

/// A coupler: no process data, no mailbox.
#[must_use]
pub fn coupler() -> DeviceDescription {
    DeviceDescription {
        origin: "coupler".to_owned(),
        identity: Identity { vendor: VENDOR, product: 0x0004_0001, revision: 0x0001_0000, serial: 0 },
        name: "SIM-CPL".to_owned(),
        title: "Simulated coupler".to_owned(),
        group: "Simulated".to_owned(),
        profile: Profile::Plain,
        memory: 0x1000,
        sync_managers: Vec::new(),
        fmmus: Vec::new(),
        mailbox: None,
        clock: Some(ClockDescription { sync: false, wide: true, min_cycle_ns: 0 }),
        objects: Vec::new(),
        pdos: Vec::new(),
        channels: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Direction;
    use super::*;

    #[test]
    fn every_device_that_comes_with_the_crate_is_valid() {
        for device in [drive(), load_cell(), encoder(1), encoder(32), coupler()] {
            device.check().unwrap();
            assert_eq!(device.identity.vendor, VENDOR);
        }
        assert_eq!(encoder(4).default_length(Direction::Inputs), 4 * 6);
    }
}
