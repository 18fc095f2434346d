//! SDO information: lists of objects, descriptions of objects and entries, in fragments.
//!
//! Source: ETG.1000.6, 5.6.3.

use super::sdo::coe_header;
use super::{Abort, SDO_INFORMATION};
use crate::bytes::u16_at;
use crate::description::{Access, Direction, ObjectCode};
use crate::dictionary::{Dictionary, Object};

/// Operations.
const LIST: u8 = 1;
const OBJECT: u8 = 3;
const ENTRY: u8 = 5;
const ERROR: u8 = 7;
const INCOMPLETE: u8 = 0x80;
/// CoE header, operation, reserved octet, fragments left.
const HEADER: usize = 6;
/// What an entry's description may contain besides the name.
const DEFAULT_VALUE: u8 = 0x10;
const MINIMUM: u8 = 0x20;
const MAXIMUM: u8 = 0x40;

/// The answers to a request, in order; all with CoE header and of at most `room` octets.
pub(crate) fn answer(dictionary: &Dictionary, request: &[u8], room: usize) -> Vec<Vec<u8>> {
    let operation = request.get(2).copied().unwrap_or(0) & 0x7f;
    let data = request.get(HEADER..).unwrap_or_default();
    let content = match operation {
        LIST => list(dictionary, u16_at(data, 0)),
        OBJECT => object(dictionary, u16_at(data, 0)),
        ENTRY => {
            let octet = |at: usize| data.get(at).copied().unwrap_or(0);
            entry(dictionary, u16_at(data, 0), octet(2), octet(3))
        }
        _ => Err(Abort::Command),
    };
    match content {
        Ok(content) => fragments(operation + 1, &content, room.max(HEADER + 2)),
        Err(abort) => fragments(ERROR, &abort.number().to_le_bytes(), room.max(HEADER + 4)),
    }
}

fn fragments(operation: u8, content: &[u8], room: usize) -> Vec<Vec<u8>> {
    // Whole indices in each fragment.
    let size = (room - HEADER) / 2 * 2;
    let count = content.len().div_ceil(size).max(1);
    (0..count)
        .map(|at| {
            let left = count - 1 - at;
            let mut answer = coe_header(SDO_INFORMATION);
            answer.extend([operation | if left > 0 { INCOMPLETE } else { 0 }, 0]);
            answer.extend((left as u16).to_le_bytes());
            answer.extend(content.chunks(size).nth(at).unwrap_or_default());
            answer
        })
        .collect()
}

/// Lists 1 to 5, and the number of objects in each as list 0.
fn list(dictionary: &Dictionary, kind: u16) -> Result<Vec<u8>, Abort> {
    let indices = |kind| -> Vec<u16> {
        dictionary
            .objects()
            .iter()
            .filter(|object| is_in(dictionary, object, kind))
            .map(|object| object.index)
            .collect()
    };
    let numbers: Vec<u16> = match kind {
        0 => (1..=5).map(|kind| indices(kind).len() as u16).collect(),
        1..=5 => indices(kind),
        _ => return Err(Abort::Range),
    };
    Ok([kind].into_iter().chain(numbers).flat_map(u16::to_le_bytes).collect())
}

fn is_in(dictionary: &Dictionary, object: &Object, kind: u16) -> bool {
    let mut entries = dictionary.entries(object).iter();
    match kind {
        1 => true,
        2 => entries.any(|entry| entry.description.pdo.allows(Direction::Outputs)),
        3 => entries.any(|entry| entry.description.pdo.allows(Direction::Inputs)),
        // What a replacement device needs, and what may be written at start: settings.
        _ => entries.any(|entry| {
            let pdo = entry.description.pdo;
            let mapped = pdo.allows(Direction::Outputs) || pdo.allows(Direction::Inputs);
            !mapped && matches!(entry.description.access, Access::ReadWrite | Access::WriteInPreOp)
        }),
    }
}

fn object(dictionary: &Dictionary, index: u16) -> Result<Vec<u8>, Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    let entries = dictionary.entries(object);
    let last = entries.last().map_or(0, |entry| entry.description.subindex);
    // The type of a variable or of an array's entries; records have none.
    let typed = match object.code {
        ObjectCode::Variable => entries.first(),
        ObjectCode::Array => entries.get(1),
        ObjectCode::Record => None,
    };
    let data_type = typed.map_or(0, |entry| entry.description.data_type.number(entry.description.bits));
    let mut content = Vec::new();
    content.extend(index.to_le_bytes());
    content.extend(data_type.to_le_bytes());
    content.extend([last, object.code.number()]);
    content.extend(object.name.bytes());
    Ok(content)
}

fn entry(dictionary: &Dictionary, index: u16, subindex: u8, desired: u8) -> Result<Vec<u8>, Abort> {
    let object = dictionary.object(index).ok_or(Abort::NoObject)?;
    let entries = dictionary.entries(object);
    let last = entries.last().map_or(0, |entry| entry.description.subindex);
    let Some(entry) = entries.iter().find(|entry| entry.description.subindex == subindex) else {
        // A gap between entries is described as empty, so that a master can go through all of them.
        let [low, high] = index.to_le_bytes();
        let gap = vec![low, high, subindex, 0, 0, 0, 0, 0, 0, 0];
        return if subindex < last { Ok(gap) } else { Err(Abort::NoSubindex) };
    };
    let description = &entry.description;
    let mappable = |direction, bit: u16| if description.pdo.allows(direction) { bit } else { 0 };
    let rights =
        description.access.rights() | mappable(Direction::Outputs, 0x40) | mappable(Direction::Inputs, 0x80);
    let given = if description.limits.is_some() {
        desired & (DEFAULT_VALUE | MINIMUM | MAXIMUM)
    } else {
        desired & DEFAULT_VALUE
    };
    let mut content = Vec::new();
    content.extend(index.to_le_bytes());
    content.extend([subindex, given]);
    content.extend(description.data_type.number(description.bits).to_le_bytes());
    content.extend(description.bits.to_le_bytes());
    content.extend(rights.to_le_bytes());
    if given & DEFAULT_VALUE != 0 {
        let mut value = description.value.clone();
        value.resize(entry.capacity(), 0);
        content.extend(value);
    }
    let (low, high) = description.limits.unwrap_or_default();
    for (flag, limit) in [(MINIMUM, low), (MAXIMUM, high)] {
        if given & flag != 0 {
            content.extend(&limit.to_le_bytes()[..entry.capacity().min(8)]);
        }
    }
    content.extend(description.name.bytes());
    Ok(content)
}
