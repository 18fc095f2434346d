//! The description of a device: plain data, checked when a device is made from it.

use super::{Access, DataType, Direction, FmmuUse, ObjectCode, PdoMappable, Profile, SyncManagerKind};
use serde::Deserialize;

/// Numbers by which masters recognise a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Vendor ID.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision number.
    pub revision: u32,
    /// Serial number.
    #[serde(default)]
    pub serial: u32,
}

/// A sync manager with its defaults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SyncManagerDescription {
    /// What it carries.
    pub kind: SyncManagerKind,
    /// First octet in the device's memory.
    pub start: u16,
    /// Octets of a mailbox; process data take the length of their PDOs.
    #[serde(default)]
    pub length: u16,
    /// Whether the process-data watchdog supervises it.
    #[serde(default)]
    pub watchdog: bool,
}

/// What a mailbox can do besides SDO transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MailboxDescription {
    /// Lists and descriptions of objects.
    pub information: bool,
    /// All entries of an object in one transfer.
    pub complete_access: bool,
    /// Which PDOs are exchanged may be changed.
    pub assignment: bool,
    /// What a PDO contains may be changed.
    pub mapping: bool,
}

/// Distributed clocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClockDescription {
    /// Synchronised operation is possible (SYNC0); otherwise receive times are measured and nothing else.
    pub sync: bool,
    /// 64 bits instead of 32.
    pub wide: bool,
    /// Shortest cycle in ns; 0 is no limit.
    pub min_cycle_ns: u32,
}

/// An entry of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct EntryDescription {
    /// Subindex.
    pub subindex: u8,
    /// Name.
    pub name: String,
    /// Type.
    pub data_type: DataType,
    /// Bits; whole octets for texts, where it is the longest value.
    pub bits: u16,
    /// Rights.
    pub access: Access,
    /// Whether it may be process data.
    pub pdo: PdoMappable,
    /// Value at start, as on the wire; at most as long as `bits`, zeros are added (not to texts and octets).
    pub value: Vec<u8>,
    /// Smallest and largest value that the master may write, whole numbers only.
    pub limits: Option<(i64, i64)>,
}

/// An object of the dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectDescription {
    /// Index.
    pub index: u16,
    /// Name.
    pub name: String,
    /// Kind.
    pub code: ObjectCode,
    /// Entries in ascending order of their subindex; arrays and records begin with the number of entries.
    pub entries: Vec<EntryDescription>,
}

/// One object in a PDO; index 0 is a gap. In a table `[index, subindex, bits]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(from = "(u16, u8, u8)")]
pub struct PdoEntry {
    /// Index of the object, 0 for a gap.
    pub index: u16,
    /// Subindex.
    pub subindex: u8,
    /// Bits.
    pub bits: u8,
}

impl From<(u16, u8, u8)> for PdoEntry {
    fn from((index, subindex, bits): (u16, u8, u8)) -> Self {
        Self { index, subindex, bits }
    }
}

/// Process data that are exchanged together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PdoDescription {
    /// Index, 0x1600 to 0x17ff for outputs and 0x1a00 to 0x1bff for inputs.
    pub index: u16,
    /// Name.
    pub name: String,
    /// Whether it is exchanged by default.
    pub assigned: bool,
    /// Its content cannot be changed.
    pub fixed: bool,
    /// Objects in the order on the wire.
    pub entries: Vec<PdoEntry>,
}

impl PdoDescription {
    /// Outputs or inputs, by the index.
    #[must_use]
    pub fn direction(&self) -> Direction {
        if self.index < 0x1800 { Direction::Outputs } else { Direction::Inputs }
    }

    /// Bits of all entries.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.entries.iter().map(|entry| usize::from(entry.bits)).sum()
    }
}

/// A device as data.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceDescription {
    /// Name of the file, or of the device, for errors.
    pub origin: String,
    /// Numbers by which masters recognise it.
    pub identity: Identity,
    /// Short name (order number).
    pub name: String,
    /// Long name.
    pub title: String,
    /// Group.
    pub group: String,
    /// What it does with its objects.
    pub profile: Profile,
    /// Octets of process-data memory, from 0x1000.
    pub memory: u16,
    /// Sync managers in the order of their channels.
    pub sync_managers: Vec<SyncManagerDescription>,
    /// What the memory management units are meant for.
    pub fmmus: Vec<FmmuUse>,
    /// Mailbox with CoE, where there is one.
    pub mailbox: Option<MailboxDescription>,
    /// Distributed clocks, where there are any.
    pub clock: Option<ClockDescription>,
    /// Objects in ascending order of their index. Objects that follow from the rest (identity, PDOs and their
    /// assignment, types of the sync managers) may be left out.
    pub objects: Vec<ObjectDescription>,
    /// Process data.
    pub pdos: Vec<PdoDescription>,
    /// Entries that are set from outside with [`Device::set_input`](crate::Device::set_input), by channel.
    pub channels: Vec<(u16, u8)>,
}
