//! Fields of a state message, in their order.

use serde_json::{Value, json};

/// Characters at the beginning of every message.
const MAGIC: [u8; 4] = *b"SNLV";
/// Version of the messages.
const VERSION: u16 = 1;

/// Kinds of messages of the server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub(crate) enum MessageKind {
    /// The fields of the layout.
    State = 1,
    /// The page is to read `/scene` again.
    Scene = 2,
    /// The answer to a command, JSON.
    Answer = 4,
}

/// Type of the numbers of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    U8,
    U16,
    F32,
    F64,
}

/// One field: name, type, number of numbers, unit.
pub(crate) type Field = (&'static str, NumberType, usize, &'static str);

/// Fields in the order of a message; little endian, packed.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    fields: Vec<Field>,
}

impl Layout {
    /// For these numbers of bodies, joints, muscles and points of all cables; with a second machine beside the first.
    pub(crate) fn new([bodies, joints, muscles, points]: [usize; 4], compared: bool) -> Self {
        use NumberType::{F32, F64, U8, U16};
        let mut fields = vec![
            ("time_s", F64, 1, "s"),
            ("sequence", F64, 1, "1"),
            ("mode", U8, 1, "1"),
            ("fault", U16, 1, "1"),
            ("fault_index", U16, 1, "1"),
            ("flags", U16, 1, "1"),
            ("speed", F64, 1, "1"),
            ("body_pose", F32, 7 * bodies, "m, 1"),
            ("reference_pose", F32, 7 * bodies, "m, 1"),
            ("cable_points", F32, 3 * points, "m"),
            ("cable_tension", F32, points, "N"),
            ("cable_sliding", U8, points, "1"),
            ("end_point", F64, 3, "m"),
            ("end_point_reference", F64, 3, "m"),
            ("joint_true", F64, joints, "rad or m"),
            ("joint_estimated", F64, joints, "rad or m"),
            ("joint_reference", F64, joints, "rad or m"),
            ("tension_in", F64, muscles, "N"),
            ("tension_out_desired", F64, muscles, "N"),
            ("tension_out_estimated", F64, muscles, "N"),
            ("tension_out_true", F64, muscles, "N"),
            ("winch_position", F64, muscles, "m"),
            ("motor_temperature", F64, muscles, "degC"),
        ];
        if compared {
            fields.push(("body_pose_2", F32, 7 * bodies, "m, 1"));
            fields.push(("end_point_2", F64, 3, "m"));
        }
        Self { fields }
    }

    /// As `/scene` describes it.
    pub(crate) fn json(&self) -> Value {
        let field = |(name, kind, count, unit): &Field| {
            let kind = match kind {
                NumberType::U8 => "u8",
                NumberType::U16 => "u16",
                NumberType::F32 => "f32",
                NumberType::F64 => "f64",
            };
            json!({"name": name, "type": kind, "count": count, "unit": unit})
        };
        self.fields.iter().map(field).collect()
    }

    /// A state message: `numbers` gives those of a field, `count` of them.
    pub(crate) fn message(&self, revision: u32, mut numbers: impl FnMut(&str, &mut Vec<f64>)) -> Vec<u8> {
        let (mut body, mut values) = (Vec::new(), Vec::new());
        for (name, kind, count, _) in &self.fields {
            values.clear();
            numbers(name, &mut values);
            values.resize(*count, f64::NAN);
            for value in &values {
                match kind {
                    NumberType::U8 => body.push(*value as u8),
                    NumberType::U16 => body.extend((*value as u16).to_le_bytes()),
                    NumberType::F32 => body.extend((*value as f32).to_le_bytes()),
                    NumberType::F64 => body.extend(value.to_le_bytes()),
                }
            }
        }
        message(MessageKind::State, revision, &body)
    }
}

/// A message with its head of 16 bytes.
pub(crate) fn message(kind: MessageKind, revision: u32, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 + body.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((kind as u16).to_le_bytes());
    bytes.extend(u32::try_from(body.len()).unwrap_or(u32::MAX).to_le_bytes());
    bytes.extend(revision.to_le_bytes());
    bytes.extend(body);
    bytes
}
