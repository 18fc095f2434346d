//! Fields of a state message, in their order.

use crate::drawing::POINTS;
use serde_json::{Value, json};
use sinew::machine::Machine;
use sinew_session::signals::{Axis, Kind, Signal};

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
    /// Rows of the fields that are plotted.
    History = 5,
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

/// What the states of a source contain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Contents {
    /// Bodies, joints, muscles.
    pub(crate) sizes: [usize; 3],
    /// Whether tensions are known, and joints other than those of the reference.
    pub(crate) forces: bool,
    /// Whether the true state of the machine is known.
    pub(crate) truth: bool,
    /// Signals that are not known, a bit each.
    pub(crate) lacks: u64,
    /// Whether the cycle keeps deadlines, whose times are shown.
    pub(crate) timed: bool,
    /// Whether a second machine is shown beside the first.
    pub(crate) second: bool,
}

impl Contents {
    /// Of a machine that is simulated on the page itself.
    pub(crate) fn simulated(machine: &Machine) -> Self {
        let robot = &machine.robot;
        let sizes = [robot.parts().bodies.len(), robot.independent_joints().len(), machine.muscles.len()];
        Self { sizes, forces: true, truth: true, lacks: 0, timed: false, second: false }
    }
}

/// Fields in the order of a message; little endian, packed.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    fields: Vec<Field>,
}

/// Durations of the parts of a cycle.
const TIMES: [Signal; 4] = [Signal::WakeUp, Signal::Read, Signal::Control, Signal::Write];

/// Whether a field is drawn, not plotted.
fn is_geometry(name: &str) -> bool {
    ["body_pose", "reference_pose", "cable_"].iter().any(|start| name.starts_with(start))
}

impl Layout {
    /// The fields of a source's states.
    pub(crate) fn new(contents: &Contents) -> Self {
        use NumberType::{F32, F64, U8, U16};
        let Contents { sizes: [bodies, joints, muscles], forces, truth, lacks, timed, second } = *contents;
        let points = muscles * POINTS;
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
        ];
        for signal in Signal::ALL {
            let row = signal.row();
            let shown = match row.axis {
                Axis::Cycle => timed && TIMES.contains(signal),
                _ if *signal == Signal::JointReference => true,
                _ => forces && (truth || row.kind != Kind::Truth) && lacks >> *signal as u64 & 1 == 0,
            };
            let count = match row.axis {
                Axis::Cycle => 1,
                Axis::Joint => joints,
                Axis::Muscle => muscles,
            };
            if shown {
                fields.push((row.name, F64, count, row.unit));
            }
        }
        if second {
            fields.push(("body_pose_2", F32, 7 * bodies, "m, 1"));
            fields.push(("end_point_2", F64, 3, "m"));
            fields.push(("joint_2", F64, joints, "rad or m"));
            fields.push(("tension_out_2", F64, muscles, "N"));
        }
        Self { fields }
    }

    /// Whether a field is there.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|(field, ..)| *field == name)
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

    /// A state message: `numbers` gives those of a field.
    pub(crate) fn state(&self, revision: u32, numbers: impl FnMut(&str, &mut Vec<f64>)) -> Vec<u8> {
        let mut body = Vec::new();
        pack(self.fields.iter(), numbers, &mut body);
        message(MessageKind::State, revision, &body)
    }

    /// Adds a row of a history: the fields that are plotted.
    pub(crate) fn history_row(&self, out: &mut Vec<u8>, numbers: impl FnMut(&str, &mut Vec<f64>)) {
        pack(self.fields.iter().filter(|(name, ..)| !is_geometry(name)), numbers, out);
    }
}

/// Packs the numbers of fields; NaN where too few are given.
fn pack<'a>(
    fields: impl Iterator<Item = &'a Field>,
    mut numbers: impl FnMut(&str, &mut Vec<f64>),
    out: &mut Vec<u8>,
) {
    let mut values = Vec::new();
    for (name, kind, count, _) in fields {
        values.clear();
        numbers(name, &mut values);
        values.resize(*count, f64::NAN);
        for value in &values {
            match kind {
                NumberType::U8 => out.push(*value as u8),
                NumberType::U16 => out.extend((*value as u16).to_le_bytes()),
                NumberType::F32 => out.extend((*value as f32).to_le_bytes()),
                NumberType::F64 => out.extend(value.to_le_bytes()),
            }
        }
    }
}

/// The numbers of the fields of a state, by the layout of its scene.
#[cfg(feature = "foxglove")]
pub(crate) fn unpack(layout: &Value, body: &[u8]) -> std::collections::BTreeMap<String, Vec<f64>> {
    let (mut fields, mut rest) = (std::collections::BTreeMap::new(), body);
    for field in layout.as_array().into_iter().flatten() {
        let bytes = match field["type"].as_str() {
            Some("u8") => 1,
            Some("u16") => 2,
            Some("f32") => 4,
            _ => 8,
        };
        let count = field["count"].as_u64().unwrap_or(0) as usize;
        let Some((taken, after)) = rest.split_at_checked(bytes * count) else { break };
        rest = after;
        let number = |part: &[u8]| match *part {
            [byte] => f64::from(byte),
            [a, b] => f64::from(u16::from_le_bytes([a, b])),
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => part.try_into().map_or(f64::NAN, f64::from_le_bytes),
        };
        let name = field["name"].as_str().unwrap_or_default().to_owned();
        fields.insert(name, taken.chunks_exact(bytes).map(number).collect());
    }
    fields
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
