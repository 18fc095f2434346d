//! The messages with the signals: fields by the names of the columns, and their schema.
//!
//! A column `position_in_m:biceps` is the field `position_in_m.biceps`, one without a part a field of its
//! own. Time is that of the message.

use crate::head::{ColumnSpec, Head};
use prost::Message;
use prost::encoding::{WireType, decode_key, decode_varint, encode_key, encode_varint};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use sinew_session::signals::Signal;

/// Signals whose numbers change in every cycle come first: the rest of a message then is one match for the
/// compression.
const FIRST: [Signal; 4] = [Signal::PositionIn, Signal::TensionIn, Signal::Command, Signal::Joint];

/// A field of a message.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    /// Names of the parts; none for a number of the cycle.
    parts: Vec<String>,
    /// Columns, one for every part.
    columns: Vec<usize>,
}

/// The fields of a message; a field's number is its place and 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fields(Vec<Field>);

impl Fields {
    /// Of columns of a kind, all but the deadline.
    pub(crate) fn new(columns: &[ColumnSpec]) -> Self {
        let mut fields: Vec<Field> = Vec::new();
        for (column, spec) in columns.iter().enumerate() {
            let (name, part) = spec.name.split_once(':').map_or((&*spec.name, None), |(a, b)| (a, Some(b)));
            if name == Signal::Deadline.row().name {
                continue;
            }
            let found = fields.iter().position(|field| field.name == name && part.is_some());
            let place = found.unwrap_or(fields.len());
            if found.is_none() {
                fields.push(Field { name: name.to_owned(), parts: Vec::new(), columns: Vec::new() });
            }
            fields[place].columns.push(column);
            fields[place].parts.extend(part.map(str::to_owned));
        }
        let rank = |field: &Field| FIRST.iter().position(|signal| field.name.starts_with(signal.row().name));
        fields.sort_by_key(|field| {
            if field.parts.is_empty() { None } else { rank(field) }.unwrap_or(FIRST.len())
        });
        Self(fields)
    }

    /// The message of a row of columns.
    pub(crate) fn encode(&self, columns: &[Vec<f64>], row: usize) -> Vec<u8> {
        let mut message = Vec::new();
        let put = |to: &mut Vec<u8>, number: usize, value: f64| {
            encode_key(number as u32 + 1, WireType::SixtyFourBit, to);
            to.extend(value.to_le_bytes());
        };
        // Zero is the default of a field.
        let zero = |column: &usize| columns[*column][row].to_bits() == 0;
        for (number, field) in self.0.iter().enumerate() {
            if field.parts.is_empty() {
                field
                    .columns
                    .iter()
                    .filter(|k| !zero(k))
                    .for_each(|k| put(&mut message, number, columns[*k][row]));
                continue;
            }
            let mut body = Vec::new();
            if !field.columns.iter().all(zero) {
                (0..).zip(&field.columns).for_each(|(part, k)| put(&mut body, part, columns[*k][row]));
            }
            encode_key(number as u32 + 1, WireType::LengthDelimited, &mut message);
            encode_varint(body.len() as u64, &mut message);
            message.extend(body);
        }
        message
    }

    /// Sets the numbers of a row from its message; none for a message of another schema.
    pub(crate) fn decode(&self, mut message: &[u8], columns: &mut [Vec<f64>], row: usize) -> Option<()> {
        while !message.is_empty() {
            let (tag, wire) = decode_key(&mut message).ok()?;
            let field = self.0.get(tag as usize - 1)?;
            let mut body = match (wire, field.parts.is_empty()) {
                (WireType::LengthDelimited, false) => {
                    let length = usize::try_from(decode_varint(&mut message).ok()?).ok()?;
                    message.split_off(..length)?
                }
                (WireType::SixtyFourBit, true) => {
                    *columns.get_mut(*field.columns.first()?)?.get_mut(row)? = number(&mut message)?;
                    continue;
                }
                _ => return None,
            };
            while !body.is_empty() {
                let (tag, wire) = decode_key(&mut body).ok()?;
                let column =
                    *field.columns.get(tag as usize - 1).filter(|_| wire == WireType::SixtyFourBit)?;
                *columns.get_mut(column)?.get_mut(row)? = number(&mut body)?;
            }
        }
        Some(())
    }

    /// Part and path of the number of every column.
    pub(crate) fn paths(&self, columns: usize) -> Vec<(String, String)> {
        let mut paths = vec![(String::new(), String::new()); columns];
        for (name, field) in identifiers(self.0.iter().map(|field| &*field.name)).zip(&self.0) {
            let parts = identifiers(field.parts.iter().map(String::as_str));
            for ((column, part), path) in field.columns.iter().zip(&field.parts).zip(parts) {
                paths[*column] = (part.clone(), format!("{name}.{path}"));
            }
            if let (true, [column]) = (field.parts.is_empty(), &field.columns[..]) {
                paths[*column].1 = name;
            }
        }
        paths
    }

    /// A `FileDescriptorSet` with the message of a name in the package `sinew`.
    pub(crate) fn schema(&self, message: &str) -> Vec<u8> {
        let (mut fields, mut nested) = (Vec::new(), Vec::new());
        for ((name, field), k) in identifiers(self.0.iter().map(|field| &*field.name)).zip(&self.0).zip(1..) {
            let type_name = (!field.parts.is_empty()).then(|| format!("Of_{name}"));
            if let Some(type_name) = &type_name {
                let parts = identifiers(field.parts.iter().map(String::as_str));
                let parts = parts.zip(1..).map(|(name, k)| described(name, k, None)).collect();
                let name = Some(type_name.clone());
                nested.push(DescriptorProto { name, field: parts, ..DescriptorProto::default() });
            }
            fields.push(described(name, k, type_name.map(|name| format!(".sinew.{message}.{name}"))));
        }
        let name = Some(message.to_owned());
        let message_type =
            vec![DescriptorProto { name, field: fields, nested_type: nested, ..DescriptorProto::default() }];
        let file = FileDescriptorProto {
            name: Some(format!("sinew/{message}.proto")),
            package: Some("sinew".to_owned()),
            message_type,
            syntax: Some("proto3".to_owned()),
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }
}

impl Head {
    /// The parts of a signal, and the paths of their numbers in the messages:
    /// `/sinew/cycle.position_in_m.biceps`.
    #[must_use]
    pub fn paths(&self, signal: Signal) -> Vec<(String, String)> {
        let (topic, columns) =
            if self.is_slow(signal) { ("/sinew/slow", &self.slow) } else { ("/sinew/cycle", &self.fast) };
        let first = self.place(signal).unwrap_or(columns.len());
        let paths = Fields::new(columns).paths(columns.len());
        let of = |path: &(String, String)| (path.0.clone(), format!("{topic}.{}", path.1));
        paths.iter().skip(first).take(self.names(signal).len()).map(of).collect()
    }
}

/// A double, or the message of a type.
fn described(name: String, number: i32, type_name: Option<String>) -> FieldDescriptorProto {
    let kind = if type_name.is_some() { Type::Message } else { Type::Double };
    FieldDescriptorProto {
        name: Some(name),
        number: Some(number),
        label: Some(Label::Optional as i32),
        r#type: Some(kind as i32),
        type_name,
        ..FieldDescriptorProto::default()
    }
}

fn number(bytes: &mut &[u8]) -> Option<f64> {
    let (number, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(f64::from_le_bytes(*number))
}

/// Names as Protocol Buffers allow them, none twice, not even in another spelling of capitals and
/// underscores.
fn identifiers<'a>(names: impl Iterator<Item = &'a str>) -> impl Iterator<Item = String> {
    let mut seen: Vec<String> = Vec::new();
    names.map(move |name| {
        let kept = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = name.chars().map(kept).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name.insert_str(0, "part_");
        }
        let plain = |name: &str| name.replace('_', "").to_ascii_lowercase();
        while seen.contains(&plain(&name)) {
            name.push_str("_x");
        }
        seen.push(plain(&name));
        name
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::head::Coding;
    use proptest::prelude::*;

    fn fields() -> Fields {
        let spec = |name: &&str| ColumnSpec { name: (*name).to_owned(), coding: Coding::Rounded(1.0) };
        Fields::new(&["deadline_us", "mode", "joint_rad:k", "x:a", "x:b", "joint_m:s"].each_ref().map(spec))
    }

    proptest! {
        #[test]
        fn every_row_comes_back(values in prop::collection::vec(any::<u64>(), 6)) {
            let columns: Vec<Vec<f64>> = values.iter().map(|bits| vec![f64::from_bits(*bits)]).collect();
            let mut back = vec![vec![0.0]; 6];
            prop_assert!(fields().decode(&fields().encode(&columns, 0), &mut back, 0).is_some());
            let same = |k: usize| back[k][0].to_bits() == values[k];
            prop_assert!((1..6).all(same));
        }

        #[test]
        fn any_bytes_are_refused_or_decoded_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
            let _ = fields().decode(&bytes, &mut vec![vec![0.0]; 6], 0);
        }
    }

    #[test]
    fn names_that_a_schema_does_not_allow_are_replaced_and_stay_apart() {
        let names: Vec<String> = identifiers(["a b", "a_b", "aB", "7", "Füße"].into_iter()).collect();
        assert_eq!(names, ["a_b", "a_b_x", "aB_x_x", "part_7", "F__e"]);
    }
}
