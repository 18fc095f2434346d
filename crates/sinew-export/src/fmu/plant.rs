//! A plant that a process simulates: what it takes, what it says, and the file that it is made from.

use super::description::{Description, Variable, VariableKind};
use super::unit_of::unit;

/// A number that goes into a plant or comes out.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// The part that it belongs to: a terminal of FMI 3.0.
    pub part: String,
    /// What it is, with its unit as in names of columns; a whole number that is 0 or 1 has none.
    pub name: String,
    /// In a sentence.
    pub description: String,
    /// Before it is set; of an output nothing.
    pub start: f64,
}

/// A plant: inputs that hold over a step, outputs at its end.
///
/// The process is `sinew export serve FILE`, where `FILE` holds the plant. It says 0 and its outputs first,
/// then once for every message of a step's length, s, and the inputs; where it cannot step it says 1 in the
/// place of 0. All are numbers of 64 bits in the byte order of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// In a sentence.
    pub description: String,
    /// What the process reads.
    pub file: String,
    /// Usual length of a step, s.
    pub step_s: f64,
    /// In the order of the messages.
    pub inputs: Vec<Port>,
    /// Numbers that come out.
    pub outputs: Vec<Port>,
    /// Conditions that come out after them.
    pub flags: Vec<Port>,
}

impl Plant {
    pub(super) fn description(&self) -> Description {
        let ports = |ports: &[Port], kind: fn(f64) -> VariableKind| {
            let variable = |port: &Port| Variable {
                name: format!("{}.{}", port.part, port.name),
                description: port.description.clone(),
                unit: unit(&port.name),
                terminal: Some((port.part.clone(), port.name.clone())),
                kind: kind(port.start),
            };
            ports.iter().map(variable).collect::<Vec<_>>()
        };
        let mut variables = vec![Variable::time()];
        variables.extend(ports(&self.inputs, |start| VariableKind::Input { start }));
        variables.extend(ports(&self.outputs, |_| VariableKind::Number));
        variables.extend(ports(&self.flags, |_| VariableKind::Flag));
        let token = format!("{{sinew-plant-{:08x}}}", crc32fast::hash(self.file.as_bytes()));
        let description = self.description.clone();
        Description { description, token, variables, step_s: self.step_s, needs_tool: true }
    }
}
