//! Process data of one device: which objects are exchanged, and the copies between objects and sync managers.
//!
//! Source: ETG.1000.6, 5.6.7.4.7 to 5.6.7.4.9 (PDO mapping and assignment).

use crate::bytes::copy_bits;
use crate::description::{Direction, PdoMappable, SyncManagerKind};
use crate::dictionary::Dictionary;

/// One object in the process data: bits of the values to bits of the sync manager.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Copied {
    value_bit: usize,
    image_bit: usize,
    bits: usize,
}

/// Process data of one direction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct ProcessData {
    copied: Vec<Copied>,
    bits: usize,
}

impl ProcessData {
    /// Reads the assignment of a sync manager. PDOs and objects that do not exist count with their length and
    /// are not copied.
    pub(crate) fn assigned(dictionary: &Dictionary, channel: usize) -> Self {
        let mut data = Self::default();
        let assignment = 0x1c10 + channel as u16;
        for pdo in 1..=dictionary.number(assignment, 0) as u8 {
            data.append_pdo(dictionary, dictionary.number(assignment, pdo) as u16);
        }
        data
    }

    /// Of one PDO by the index of its mapping.
    pub(crate) fn of(dictionary: &Dictionary, pdo: u16) -> Self {
        let mut data = Self::default();
        data.append_pdo(dictionary, pdo);
        data
    }

    fn append_pdo(&mut self, dictionary: &Dictionary, pdo: u16) {
        for mapped in 1..=dictionary.number(pdo, 0) as u8 {
            self.append(dictionary, Mapped::from_number(dictionary.number(pdo, mapped) as u32));
        }
    }

    fn append(&mut self, dictionary: &Dictionary, mapped: Mapped) {
        if let Some(slot) = dictionary.slot(mapped.index, mapped.subindex).filter(|_| mapped.index != 0) {
            // Neighbours that stay neighbours are one copy; an own copy for each also serves, only slower.
            self.copied.push(Copied { value_bit: 8 * slot.offset, image_bit: self.bits, bits: mapped.bits });
        }
        self.bits += mapped.bits;
    }

    /// Octets on the wire.
    pub(crate) fn length(&self) -> usize {
        self.bits.div_ceil(8)
    }

    /// From the objects to the wire.
    pub(crate) fn collect(&self, dictionary: &Dictionary, image: &mut [u8]) {
        for copy in &self.copied {
            copy_bits(dictionary.values(), copy.value_bit, image, copy.image_bit, copy.bits);
        }
    }

    /// From the wire to the objects.
    pub(crate) fn distribute(&self, image: &[u8], dictionary: &mut Dictionary) {
        for copy in &self.copied {
            copy_bits(image, copy.image_bit, dictionary.values_mut(), copy.value_bit, copy.bits);
        }
    }
}

/// A mapped object as in an entry of a PDO: index, subindex, bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mapped {
    pub(crate) index: u16,
    pub(crate) subindex: u8,
    pub(crate) bits: usize,
}

impl Mapped {
    pub(crate) fn from_number(number: u32) -> Self {
        Self { index: (number >> 16) as u16, subindex: (number >> 8) as u8, bits: (number & 0xff) as usize }
    }

    /// Whether a gap or an object that exists, has this length and may be mapped in the direction.
    pub(crate) fn problem(self, dictionary: &Dictionary, direction: Direction) -> Option<MappingProblem> {
        if self.index == 0 {
            return None;
        }
        let Some(entry) = dictionary.entry(self.index, self.subindex) else {
            return Some(MappingProblem::NoObject);
        };
        let mappable: PdoMappable = entry.description.pdo;
        if !mappable.allows(direction) {
            return Some(MappingProblem::NotMappable);
        }
        (usize::from(entry.description.bits) != self.bits).then_some(MappingProblem::Length)
    }
}

/// Why an object cannot be mapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MappingProblem {
    NoObject,
    NotMappable,
    Length,
}

/// The channel of the sync manager that carries this kind.
pub(crate) fn channel(
    managers: &[crate::description::SyncManagerDescription],
    kind: SyncManagerKind,
) -> Option<usize> {
    managers.iter().position(|manager| manager.kind == kind)
}
