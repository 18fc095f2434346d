//! File, line and key of what the physics refuses after a machine was read.

use crate::Error;
use crate::body::Robot;
use crate::description::document::Table;
use crate::description::error::DescriptionError;
use crate::description::origin::{Keys, Origins, word};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Where the parts of a machine are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// Of the body's parts.
    origins: Origins,
    /// The file that was read first, and its keys.
    file: String,
    keys: Keys,
    /// Lines of the heads of every muscle's own table, and of the one for all.
    muscles: Vec<Option<usize>>,
    every: Option<usize>,
    joint_names: Vec<String>,
    tendon_names: Vec<String>,
}

impl Places {
    pub(super) fn new(root: &Table<'_>, robot: &Robot, origins: &Origins) -> Self {
        let parts = robot.parts();
        let names: Vec<&str> = parts.tendons.iter().map(|tendon| tendon.name.as_str()).collect();
        let own = own_tables(root);
        let line = |name: &&str| own.iter().find(|(muscle, _)| muscle == name).map(|(_, line)| *line);
        let every = root.table("every_transmission").ok().flatten();
        Self {
            origins: origins.clone(),
            file: root.file().to_string(),
            keys: Keys::from_text(root.text()),
            muscles: names.iter().map(line).collect(),
            every: every.map(|table| table.line()),
            joint_names: parts.joints.iter().map(|joint| joint.name.clone()).collect(),
            tendon_names: names.into_iter().map(String::from).collect(),
        }
    }

    /// The place of what an error names, in words: a part with its file, line and key where it has one, else
    /// the machine.
    #[must_use]
    pub fn error(&self, error: Error) -> DescriptionError {
        let (kind, index, field, must) = match error {
            Error::Part { kind, index, field, expected } => {
                (kind, index, field, format!("{field} must be {expected}"))
            }
            Error::PartOutOfDomain { kind, index, field, expected, got } => {
                (kind, index, field, format!("{field} must be {expected}, but is {got}"))
            }
            Error::EntryOutOfDomain { name: "lengths" | "moment_arms", index, .. } => {
                ("muscle", index, "path", format!("its path has no finite length and moment arms: {error}"))
            }
            _ => return self.of_machine(&error.to_string()),
        };
        let names = if kind == "joint" { &self.joint_names } else { &self.tendon_names };
        let name = names.get(index).filter(|_| ["joint", "muscle", "tendon"].contains(&kind));
        let (file, line, key) = match kind {
            "muscle" | "tendon" => self.of_muscle(index, field),
            _ => self.of_body(kind, index, field),
        };
        let place = name.map_or_else(|| format!("{kind} number {index}"), |name| format!("{kind} `{name}`"));
        let problem = key.map_or_else(|| must.clone(), |key| format!("{key}: {must}"));
        DescriptionError { file, line, place, problem }
    }

    fn of_machine(&self, problem: &str) -> DescriptionError {
        let (file, place) = (self.file.clone(), "machine".to_string());
        DescriptionError { file, line: 1, place, problem: problem.to_string() }
    }

    fn of_body(&self, kind: &'static str, index: usize, field: &str) -> (String, usize, Option<String>) {
        let (file, line) = self.origins.of(kind, index, field);
        (file, line, self.origins.key(kind, index, field))
    }

    /// In the muscle's own table, else in that for all, else in its description; of the first that has one of
    /// the keys.
    fn of_muscle(&self, index: usize, field: &str) -> (String, usize, Option<String>) {
        let own = self.muscles.get(index).copied().flatten();
        for head in own.into_iter().chain(self.every) {
            let found = keys_of(field).iter().find_map(|key| self.keys.find(head, key));
            if let Some((line, key)) = found {
                return (self.file.clone(), line, Some(key.to_string()));
            }
        }
        let (word, _) = word("tendon", field);
        for key in keys_of(field).iter().copied().chain([word.as_str()]) {
            if let Some((file, line, key)) = self.origins.written("tendon", index, key) {
                return (file, line, Some(key));
            }
        }
        match (self.origins.has("tendon", index), own) {
            (false, Some(line)) => (self.file.clone(), line, None),
            _ => {
                let (file, line) = self.origins.of("tendon", index, "");
                (file, line, None)
            }
        }
    }
}

/// Names of muscles that have tables of their own, with the lines of their heads.
pub(super) fn own_tables(root: &Table<'_>) -> Vec<(String, usize)> {
    let known: Vec<&str> = super::transmissions::TRANSMISSION.iter().copied().chain(["muscle"]).collect();
    let tables = root.tables("transmission", "muscle", &known).unwrap_or_default();
    tables.into_iter().map(|(table, muscle)| (muscle.text, table.line())).collect()
}

/// The keys of a muscle that a quantity of its cable follows from, the likeliest first.
fn keys_of(field: &str) -> &'static [&'static str] {
    match field {
        "friction angle of a node" => &["cable", "sheath_bend", "model", "sheath"],
        "bend_by_joint" => &["bend_by_joint", "sheath_bend", "sheath"],
        "compliance of a cell" => &["cable", "sheath_length", "near_length", "model", "sheath"],
        "path" => &["path"],
        _ => &[],
    }
}
