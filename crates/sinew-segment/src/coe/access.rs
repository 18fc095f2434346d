//! Reading and writing entries as the master may, one by one or all of an object.

use super::Abort;
use crate::al::AlState;
use crate::bytes::{copy_bits, signed, unsigned};
use crate::description::{Access, DataType, Direction, ObjectCode};
use crate::dictionary::{Dictionary, Entry, Object};
use crate::pdo::{Mapped, MappingProblem};

/// Octets that one datagram carries: the limit of all PDOs of one direction.
const MAX_PROCESS_DATA: usize = 1486;

/// Value of one entry.
pub(super) fn read(dictionary: &Dictionary, index: u16, subindex: u8) -> Result<Vec<u8>, Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    let entries = dictionary.entries(object);
    let entry =
        entries.iter().find(|entry| entry.description.subindex == subindex).ok_or(Abort::NoSubindex)?;
    if entry.description.access == Access::Write {
        return Err(Abort::WriteOnly);
    }
    Ok(dictionary.value(entry).to_vec())
}

/// Values of all entries, from subindex 0 (with an octet of padding behind it) or 1. Bits follow each other,
/// octets begin at octets.
pub(super) fn read_all(dictionary: &Dictionary, index: u16, from: u8) -> Result<Vec<u8>, Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    if from > 1 {
        return Err(Abort::UnsupportedAccess);
    }
    let mut all = Vec::new();
    for (place, entry) in layout(dictionary, object, from, used(dictionary, object)) {
        if entry.description.access == Access::Write {
            return Err(Abort::WriteOnly);
        }
        let value = dictionary.value(entry);
        let bits = usize::from(entry.description.bits);
        all.resize(all.len().max((place + bits).div_ceil(8)), 0);
        copy_bits(value, 0, &mut all, place, bits.min(8 * value.len()));
    }
    if all.len() == 1 && from == 0 && object.code != ObjectCode::Variable {
        all.push(0);
    }
    Ok(all)
}

/// Sets one entry after all checks.
pub(super) fn write(
    dictionary: &mut Dictionary,
    state: AlState,
    index: u16,
    subindex: u8,
    value: &[u8],
) -> Result<(), Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    let entries = dictionary.entries(object);
    let entry =
        entries.iter().find(|entry| entry.description.subindex == subindex).ok_or(Abort::NoSubindex)?;
    check_access(entry, state)?;
    check_value(entry, value)?;
    check_process_data(dictionary, index, subindex, value)?;
    dictionary.set_value(index, subindex, value);
    Ok(())
}

/// Sets all entries of an object, or none.
pub(super) fn write_all(
    dictionary: &mut Dictionary,
    state: AlState,
    index: u16,
    from: u8,
    data: &[u8],
) -> Result<(), Abort> {
    let before = dictionary.clone();
    let result = write_each(dictionary, state, index, from, data);
    if result.is_err() {
        *dictionary = before;
    }
    result
}

fn write_each(
    dictionary: &mut Dictionary,
    state: AlState,
    index: u16,
    from: u8,
    data: &[u8],
) -> Result<(), Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    if from > 1 || object.code == ObjectCode::Variable {
        return Err(Abort::UnsupportedAccess);
    }
    let count = if from == 0 { data.first().copied().unwrap_or(0) } else { u8::MAX };
    let mut values: Vec<(u8, Vec<u8>)> = Vec::new();
    for (place, entry) in layout(dictionary, object, from, count) {
        let bits = usize::from(entry.description.bits);
        if place + bits > 8 * data.len() {
            break;
        }
        let mut value = vec![0; bits.div_ceil(8)];
        copy_bits(data, place, &mut value, 0, bits);
        values.push((entry.description.subindex, value));
    }
    let first = dictionary.entry(index, 0).ok_or(Abort::NoSubindex)?;
    let counted = from == 0 && first.description.access != Access::Read;
    if counted {
        write(dictionary, state, index, 0, &[0])?;
    } else if from == 0 && dictionary.number(index, 0) != u64::from(count) {
        return Err(Abort::ReadOnly);
    }
    for (subindex, value) in values.iter().filter(|(subindex, _)| *subindex > 0) {
        write(dictionary, state, index, *subindex, value)?;
    }
    if counted { write(dictionary, state, index, 0, &[count]) } else { Ok(()) }
}

/// The highest subindex in use.
fn used(dictionary: &Dictionary, object: &Object) -> u8 {
    if object.code == ObjectCode::Variable { 0 } else { dictionary.number(object.index, 0) as u8 }
}

/// Entries up to `highest` with the bit at which each begins in a complete transfer.
fn layout<'a>(
    dictionary: &'a Dictionary,
    object: &'a Object,
    from: u8,
    highest: u8,
) -> impl Iterator<Item = (usize, &'a Entry)> {
    let entries = dictionary.entries(object).iter();
    let desired = entries.filter(move |entry| (from..=highest).contains(&entry.description.subindex));
    desired.scan(0_usize, move |next, entry| {
        let bits = usize::from(entry.description.bits);
        let place = if bits >= 8 { next.next_multiple_of(8) } else { *next };
        let padded = entry.description.subindex == 0 && object.code != ObjectCode::Variable;
        *next = if padded { place + 16 } else { place + bits };
        Some((place, entry))
    })
}

fn check_access(entry: &Entry, state: AlState) -> Result<(), Abort> {
    match entry.description.access {
        Access::Read => Err(Abort::ReadOnly),
        Access::WriteInPreOp if state != AlState::PreOp => Err(Abort::State),
        Access::Write | Access::ReadWrite | Access::WriteInPreOp => Ok(()),
    }
}

fn check_value(entry: &Entry, value: &[u8]) -> Result<(), Abort> {
    if value.len() > entry.capacity() {
        return Err(Abort::TooLong);
    }
    if value.len() < entry.capacity() && !entry.is_variable() {
        return Err(Abort::TooShort);
    }
    let finite = match entry.description.data_type {
        DataType::F32 => f32::from_bits(unsigned(value) as u32).is_finite(),
        DataType::F64 => f64::from_bits(unsigned(value)).is_finite(),
        _ => true,
    };
    if !finite {
        return Err(Abort::Range);
    }
    if let Some((low, high)) = entry.description.limits {
        let number = if entry.description.data_type.is_signed() {
            i128::from(signed(value))
        } else {
            i128::from(unsigned(value))
        };
        if number > i128::from(high) {
            return Err(Abort::TooHigh);
        }
        if number < i128::from(low) {
            return Err(Abort::TooLow);
        }
    }
    Ok(())
}

/// Rules of PDO assignment and mapping: the number is 0 while the rest changes, and what is then switched on
/// exists.
fn check_process_data(dictionary: &Dictionary, index: u16, subindex: u8, value: &[u8]) -> Result<(), Abort> {
    let direction = match index {
        0x1600..0x1800 => Some(Direction::Outputs),
        0x1a00..0x1c00 => Some(Direction::Inputs),
        0x1c10..0x1c30 => None,
        _ => return Ok(()),
    };
    if subindex > 0 {
        if dictionary.number(index, 0) != 0 {
            return Err(Abort::SubindexZero);
        }
        return match direction {
            Some(direction) => check_mapped(dictionary, unsigned(value) as u32, direction),
            None if dictionary.object(unsigned(value) as u16).is_none() => Err(Abort::Range),
            None => Ok(()),
        };
    }
    let count = unsigned(value) as u8;
    if count > 0 && dictionary.entry(index, count).is_none() {
        return Err(Abort::TooHigh);
    }
    let bits: usize = match direction {
        Some(_) => (1..=count).map(|at| Mapped::from_number(dictionary.number(index, at) as u32).bits).sum(),
        None => (1..=count).map(|at| mapped_bits(dictionary, dictionary.number(index, at) as u16)).sum(),
    };
    if bits > 8 * MAX_PROCESS_DATA { Err(Abort::PdoLength) } else { Ok(()) }
}

fn mapped_bits(dictionary: &Dictionary, pdo: u16) -> usize {
    let count = dictionary.number(pdo, 0) as u8;
    (1..=count).map(|at| Mapped::from_number(dictionary.number(pdo, at) as u32).bits).sum()
}

fn check_mapped(dictionary: &Dictionary, number: u32, direction: Direction) -> Result<(), Abort> {
    match Mapped::from_number(number).problem(dictionary, direction) {
        None => Ok(()),
        Some(MappingProblem::NoObject) => Err(Abort::NoObject),
        Some(MappingProblem::NotMappable) => Err(Abort::NotMappable),
        Some(MappingProblem::Length) => Err(Abort::Length),
    }
}
