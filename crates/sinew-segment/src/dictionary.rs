//! The objects of one device with their present values.
//!
//! Objects that follow from the rest of a description are added here: identity, types of the sync managers,
//! PDOs and their assignment, synchronisation parameters. Source: ETG.1000.6, 5.6.7.4 (CoE communication
//! area), CiA 301.

use crate::bytes::{signed, unsigned};
use crate::description::{
    Access, DataType, DeviceDescription, Direction, EntryDescription, ObjectCode, ObjectDescription,
    PdoMappable, SyncManagerKind,
};

/// Entries that a PDO with changeable content and a changeable assignment have room for.
const ROOM: usize = 32;

/// One entry with its place among the values.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) description: EntryDescription,
    offset: usize,
    length: usize,
}

impl Entry {
    /// Octets of the longest value.
    pub(crate) fn capacity(&self) -> usize {
        usize::from(self.description.bits).div_ceil(8)
    }

    /// Texts and octets have values of any length up to their capacity.
    pub(crate) fn is_variable(&self) -> bool {
        matches!(self.description.data_type, DataType::Text | DataType::Octets)
    }
}

/// One object; its entries are a range of the dictionary's.
#[derive(Debug, Clone)]
pub(crate) struct Object {
    pub(crate) index: u16,
    pub(crate) name: String,
    pub(crate) code: ObjectCode,
    entries: core::ops::Range<usize>,
}

/// Place of a value, found once and used in every cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Slot {
    pub(crate) offset: usize,
    length: usize,
    signed: bool,
}

/// All objects of a device.
#[derive(Debug, Clone)]
pub(crate) struct Dictionary {
    objects: Vec<Object>,
    entries: Vec<Entry>,
    values: Vec<u8>,
}

impl Dictionary {
    /// The objects of a description that was checked, with those that follow from it.
    pub(crate) fn new(description: &DeviceDescription, serial: u32) -> Self {
        let mut all = description.objects.clone();
        for implied in implied(description, serial) {
            if !all.iter().any(|object| object.index == implied.index) {
                all.push(implied);
            }
        }
        all.sort_by_key(|object| object.index);
        let mut dictionary = Self { objects: Vec::new(), entries: Vec::new(), values: Vec::new() };
        for object in all {
            let first = dictionary.entries.len();
            for entry in object.entries {
                let (offset, capacity) = (dictionary.values.len(), usize::from(entry.bits).div_ceil(8));
                let variable = matches!(entry.data_type, DataType::Text | DataType::Octets);
                let length = if variable { entry.value.len() } else { capacity };
                dictionary.values.resize(offset + capacity, 0);
                let used = entry.value.len().min(capacity);
                dictionary.values[offset..offset + used].copy_from_slice(&entry.value[..used]);
                dictionary.entries.push(Entry { description: entry, offset, length });
            }
            let entries = first..dictionary.entries.len();
            dictionary.objects.push(Object {
                index: object.index,
                name: object.name,
                code: object.code,
                entries,
            });
        }
        dictionary
    }

    /// All objects in ascending order.
    pub(crate) fn objects(&self) -> &[Object] {
        &self.objects
    }

    pub(crate) fn object(&self, index: u16) -> Option<&Object> {
        let at = self.objects.binary_search_by_key(&index, |object| object.index).ok()?;
        self.objects.get(at)
    }

    /// Entries of an object in ascending order of their subindex.
    pub(crate) fn entries(&self, object: &Object) -> &[Entry] {
        self.entries.get(object.entries.clone()).unwrap_or_default()
    }

    pub(crate) fn entry(&self, index: u16, subindex: u8) -> Option<&Entry> {
        let entries = self.entries(self.object(index)?);
        entries.iter().find(|entry| entry.description.subindex == subindex)
    }

    /// The present value as on the wire.
    pub(crate) fn value(&self, entry: &Entry) -> &[u8] {
        self.values.get(entry.offset..entry.offset + entry.length).unwrap_or_default()
    }

    /// The present value as an unsigned number, 0 where there is no such entry.
    pub(crate) fn number(&self, index: u16, subindex: u8) -> u64 {
        self.entry(index, subindex).map_or(0, |entry| unsigned(self.value(entry)))
    }

    /// Sets a value; one that is too long is cut, a short one is filled with zeros or, for texts, shortens
    /// the text.
    pub(crate) fn set_value(&mut self, index: u16, subindex: u8, value: &[u8]) {
        let Some(object) = self.object(index) else { return };
        let range = object.entries.clone();
        let Some(entries) = self.entries.get_mut(range) else { return };
        let Some(entry) = entries.iter_mut().find(|entry| entry.description.subindex == subindex) else {
            return;
        };
        let used = value.len().min(entry.capacity());
        if entry.is_variable() {
            entry.length = used;
        }
        if let Some(place) = self.values.get_mut(entry.offset..entry.offset + entry.capacity()) {
            place.fill(0);
            place[..used].copy_from_slice(&value[..used]);
        }
    }

    /// The place of a numeric value.
    pub(crate) fn slot(&self, index: u16, subindex: u8) -> Option<Slot> {
        let entry = self.entry(index, subindex)?;
        let signed = entry.description.data_type.is_signed();
        Some(Slot { offset: entry.offset, length: entry.capacity(), signed })
    }

    /// The number in a slot; 0 for an object that the device does not have.
    pub(crate) fn get(&self, slot: Option<Slot>) -> i64 {
        let Some(slot) = slot else { return 0 };
        let octets = self.values.get(slot.offset..slot.offset + slot.length).unwrap_or_default();
        if slot.signed { signed(octets) } else { unsigned(octets) as i64 }
    }

    /// Sets the number in a slot, limited to the range of its type.
    pub(crate) fn set(&mut self, slot: Option<Slot>, value: i64) {
        let Some(slot) = slot.filter(|slot| slot.length <= 8) else { return };
        let bits = 8 * slot.length as u32;
        let value = match (slot.signed, bits) {
            (_, 64) => value,
            (true, _) => value.clamp(-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
            (false, _) => value.clamp(0, (1 << bits) - 1),
        };
        if let Some(place) = self.values.get_mut(slot.offset..slot.offset + slot.length) {
            place.copy_from_slice(&value.to_le_bytes()[..slot.length]);
        }
    }

    /// All values; slots point into it.
    pub(crate) fn values(&self) -> &[u8] {
        &self.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut [u8] {
        &mut self.values
    }
}

pub(crate) fn entry(
    subindex: u8,
    name: &str,
    data_type: DataType,
    access: Access,
    value: &[u8],
) -> EntryDescription {
    let bits = data_type.bits().unwrap_or(8 * value.len().max(1) as u16);
    let (name, value) = (name.to_owned(), value.to_vec());
    EntryDescription { subindex, name, data_type, bits, access, pdo: PdoMappable::No, value, limits: None }
}

pub(crate) fn variable(index: u16, name: &str, data_type: DataType, value: &[u8]) -> ObjectDescription {
    let entries = vec![entry(0, name, data_type, Access::Read, value)];
    ObjectDescription { index, name: name.to_owned(), code: ObjectCode::Variable, entries }
}

pub(crate) fn record(
    index: u16,
    name: &str,
    code: ObjectCode,
    mut entries: Vec<EntryDescription>,
) -> ObjectDescription {
    entries.insert(0, EntryDescription::count(entries.last().map_or(0, |entry| entry.subindex)));
    ObjectDescription { index, name: name.to_owned(), code, entries }
}

fn implied(description: &DeviceDescription, serial: u32) -> Vec<ObjectDescription> {
    let identity = description.identity;
    let number =
        |subindex, name, value: u32| entry(subindex, name, DataType::U32, Access::Read, &value.to_le_bytes());
    let parts = vec![
        number(1, "Vendor ID", identity.vendor),
        number(2, "Product code", identity.product),
        number(3, "Revision number", identity.revision),
        number(4, "Serial number", serial),
    ];
    let mut objects = vec![
        variable(0x1000, "Device type", DataType::U32, &5001_u32.to_le_bytes()),
        variable(0x1001, "Error register", DataType::U8, &[0]),
        variable(0x1008, "Manufacturer device name", DataType::Text, description.name.as_bytes()),
        variable(0x1009, "Manufacturer hardware version", DataType::Text, b"simulated"),
        variable(
            0x100a,
            "Manufacturer software version",
            DataType::Text,
            env!("CARGO_PKG_VERSION").as_bytes(),
        ),
        record(0x1018, "Identity", ObjectCode::Record, parts),
    ];
    objects.extend(description.pdos.iter().map(|pdo| mapping(description, pdo)));
    objects.extend(communication(description));
    objects
}

/// The content of a PDO.
fn mapping(description: &DeviceDescription, pdo: &crate::description::PdoDescription) -> ObjectDescription {
    let changeable = description.mailbox.is_some_and(|mailbox| mailbox.mapping) && !pdo.fixed;
    let access = if changeable { Access::WriteInPreOp } else { Access::Read };
    let room = if changeable { pdo.entries.len().max(ROOM) } else { pdo.entries.len() };
    let mut entries = vec![entry(0, "Number of entries", DataType::U8, access, &[pdo.entries.len() as u8])];
    for at in 0..room {
        let value = pdo.entries.get(at).map_or(0, |mapped| {
            u32::from(mapped.index) << 16 | u32::from(mapped.subindex) << 8 | u32::from(mapped.bits)
        });
        let name = format!("Mapped object {}", at + 1);
        entries.push(entry(at as u8 + 1, &name, DataType::U32, access, &value.to_le_bytes()));
    }
    ObjectDescription { index: pdo.index, name: pdo.name.clone(), code: ObjectCode::Record, entries }
}

/// Types of the sync managers, PDOs assigned to them, and how they are synchronised.
fn communication(description: &DeviceDescription) -> Vec<ObjectDescription> {
    let mut objects = Vec::new();
    let mut types = Vec::new();
    for (channel, manager) in description.sync_managers.iter().enumerate() {
        let channel = channel as u8;
        let (number, direction) = match manager.kind {
            SyncManagerKind::MailboxOut => (1, None),
            SyncManagerKind::MailboxIn => (2, None),
            SyncManagerKind::Outputs => (3, Some(Direction::Outputs)),
            SyncManagerKind::Inputs => (4, Some(Direction::Inputs)),
        };
        let name = format!("Sync manager {channel}");
        types.push(entry(channel + 1, &name, DataType::U8, Access::Read, &[number]));
        objects.push(assignment(description, channel, direction));
        if let Some(direction) = direction {
            objects.push(synchronization(description, channel, direction));
        }
    }
    if !types.is_empty() {
        objects.push(record(0x1c00, "Sync manager type", ObjectCode::Array, types));
    }
    objects
}

fn assignment(
    description: &DeviceDescription,
    channel: u8,
    direction: Option<Direction>,
) -> ObjectDescription {
    let pdos: Vec<_> = description.pdos.iter().filter(|pdo| Some(pdo.direction()) == direction).collect();
    let assigned: Vec<u16> = pdos.iter().filter(|pdo| pdo.assigned).map(|pdo| pdo.index).collect();
    let changeable = description.mailbox.is_some_and(|mailbox| mailbox.assignment) && !pdos.is_empty();
    let access = if changeable { Access::WriteInPreOp } else { Access::Read };
    let room = if changeable { pdos.len().min(ROOM).max(assigned.len()) } else { assigned.len() };
    let mut entries =
        vec![entry(0, "Number of assigned PDOs", DataType::U8, access, &[assigned.len() as u8])];
    for at in 0..room {
        let value = assigned.get(at).copied().unwrap_or(0);
        let name = format!("Assigned PDO {}", at + 1);
        entries.push(entry(at as u8 + 1, &name, DataType::U16, access, &value.to_le_bytes()));
    }
    let name = format!("Sync manager {channel} PDO assignment");
    ObjectDescription { index: 0x1c10 + u16::from(channel), name, code: ObjectCode::Array, entries }
}

/// Bits of the supported synchronisation types: free run, with the sync manager's event, with SYNC0.
const FREE_RUN: u16 = 1;
const WITH_EVENT: u16 = 1 << 1;
const WITH_SYNC0: u16 = 1 << 2;

fn synchronization(description: &DeviceDescription, channel: u8, direction: Direction) -> ObjectDescription {
    let clock = description.clock.filter(|clock| clock.sync);
    let supported = FREE_RUN | WITH_EVENT | if clock.is_some() { WITH_SYNC0 } else { 0 };
    let shortest = clock.map_or(0, |clock| clock.min_cycle_ns).to_le_bytes();
    let (word, double) = (DataType::U16, DataType::U32);
    let entries = vec![
        entry(1, "Synchronization type", word, Access::ReadWrite, &1_u16.to_le_bytes()),
        entry(2, "Cycle time", double, Access::ReadWrite, &[]),
        entry(4, "Synchronization types supported", word, Access::Read, &supported.to_le_bytes()),
        entry(5, "Minimum cycle time", double, Access::Read, &shortest),
        entry(6, "Calc and copy time", double, Access::Read, &[]),
        entry(10, "Sync0 cycle time", double, Access::ReadWrite, &[]),
        entry(11, "SM event missed", word, Access::Read, &[]),
        entry(12, "Cycle exceeded", word, Access::Read, &[]),
        entry(32, "Sync error", DataType::Bool, Access::Read, &[]),
    ];
    let name = match direction {
        Direction::Outputs => "Output sync manager parameter",
        Direction::Inputs => "Input sync manager parameter",
    };
    record(0x1c30 + u16::from(channel), name, ObjectCode::Record, entries)
}
