//! File and line of every part, for errors that appear only when the robot is validated.

use super::Description;
use super::error::{DescriptionError, Warning};
use crate::body::{PartError, Parts, Robot};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Keys and table headers (`[`) of a TOML file, each with its line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Keys(Vec<(usize, String)>);

/// Whether a line is the head of a table, not a part of a list over several lines.
fn is_head(line: &str) -> bool {
    let name = line.trim_start_matches('[');
    let name = name.split(']').next().filter(|_| name.len() < line.len()).unwrap_or_default();
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && !name.contains([',', '=', '{'])
}

impl Keys {
    pub(super) fn from_text(text: &str) -> Keys {
        let told = text.lines().enumerate().filter_map(|(index, line)| {
            let line = line.trim_start();
            let key = if is_head(line) { "[" } else { line.split_once('=')?.0.trim_end() };
            Some((index + 1, key.to_string()))
        });
        Keys(told.collect())
    }

    /// The line of a key, or of the one key that is this word and a unit, in the table whose head is on a
    /// line; of the head, where the table has no such key.
    pub(super) fn line(&self, head: usize, word: &str) -> usize {
        self.find(head, word).map_or(head, |(line, _)| line)
    }

    /// That line and the whole key.
    pub(super) fn find(&self, head: usize, word: &str) -> Option<(usize, &str)> {
        let from = self.0.partition_point(|(line, _)| *line <= head);
        let within = self.0[from..].iter().take_while(|(_, key)| key != "[");
        let is = |key: &str| {
            key.strip_prefix(word).is_some_and(|rest| rest.is_empty() || rest.starts_with(['_', '.']))
        };
        within
            .into_iter()
            .find(|(_, key)| !word.is_empty() && is(key))
            .map(|(line, key)| (*line, key.as_str()))
    }
}

/// File and line of parts, by kind and place in the list of the kind.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origins {
    /// The file that parts without a line are in.
    file: String,
    lines: BTreeMap<(&'static str, usize), (String, usize)>,
    /// Keys by file, where lines are of tables that have some.
    keys: BTreeMap<String, Keys>,
}

impl Origins {
    pub(super) fn new(file: &str) -> Origins {
        Origins { file: file.to_string(), lines: BTreeMap::new(), keys: BTreeMap::new() }
    }

    /// The file that was read first.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    pub(super) fn set_keys(&mut self, file: &str, text: &str) {
        self.keys.insert(file.to_string(), Keys::from_text(text));
    }

    /// File and line of a field of a part, or of the part where the field is not known.
    pub(super) fn of(&self, kind: &'static str, index: usize, field: &str) -> (String, usize) {
        let Some((file, line)) = self.lines.get(&(kind, index)) else { return (self.file.clone(), 1) };
        let (word, _) = word(kind, field);
        (file.clone(), self.keys.get(file).map_or(*line, |keys| keys.line(*line, &word)))
    }

    /// The key that stands for a field of a part, where it is written.
    pub(super) fn key(&self, kind: &'static str, index: usize, field: &str) -> Option<String> {
        let (file, line) = self.lines.get(&(kind, index))?;
        let (word, inner) = word(kind, field);
        let (_, key) = self.keys.get(file)?.find(*line, &word)?;
        Some(inner.map_or_else(|| key.to_string(), |inner| format!("{key}: {inner}")))
    }

    /// File, line and whole key of the one key of a part that begins with a word.
    pub(super) fn written(
        &self,
        kind: &'static str,
        index: usize,
        word: &str,
    ) -> Option<(String, usize, String)> {
        let (file, head) = self.lines.get(&(kind, index))?;
        let (line, key) = self.keys.get(file)?.find(*head, word)?;
        Some((file.clone(), line, key.to_string()))
    }

    /// Whether the line of a part is known.
    pub(super) fn has(&self, kind: &'static str, index: usize) -> bool {
        self.lines.contains_key(&(kind, index))
    }

    pub(super) fn set(&mut self, kind: &'static str, index: usize, file: &str, line: usize) {
        self.lines.insert((kind, index), (file.to_string(), line));
    }
}

/// The word that a key begins with for a field of a part, and the key within its value.
pub(super) fn word(kind: &str, field: &str) -> (String, Option<&'static str>) {
    match (kind, field) {
        (_, "the length of its sheath") => ("sheath".into(), Some("length_m")),
        (_, "the bend of its sheath") => ("sheath".into(), Some("bend_rad")),
        (_, "the end axis of its sheath") => ("sheath".into(), Some("end_axis")),
        (_, "the divisor of its pulley") => ("path".into(), Some("pulley")),
        ("tendon", "its range") => ("length_range".into(), None),
        ("spring", "its spring length") => ("slack_lengths".into(), None),
        (_, "its tendon") => ("muscle".into(), None),
        _ => (field.strip_prefix("its ").unwrap_or(field).replace(' ', "_"), None),
    }
}

impl Description {
    /// The description of a robot that has been read before, from the file of this name.
    #[must_use]
    pub fn from_robot(robot: &Robot, file: &str) -> Self {
        Self { parts: robot.parts().clone(), warnings: Vec::new(), origins: Origins::new(file) }
    }

    /// The validated robot.
    ///
    /// # Errors
    ///
    /// The first invalid part, with file and line.
    pub fn robot(self) -> Result<(Robot, Vec<Warning>), DescriptionError> {
        let Description { parts, warnings, origins } = self;
        shallow(&parts, &origins)?;
        // The world is the first body.
        if parts.bodies.len() < 2 {
            let problem = "describes no body: expected at least one".to_string();
            return Err(DescriptionError {
                file: origins.file,
                line: 1,
                place: "robot".to_string(),
                problem,
            });
        }
        let robot = Robot::new(parts).map_err(|error| {
            let PartError { kind, index, name, field, expected, got } = error;
            let (file, line) = origins.of(kind, index, field);
            let place =
                if name.is_empty() { format!("{kind} number {index}") } else { format!("{kind} `{name}`") };
            let field = origins.key(kind, index, field).unwrap_or_else(|| field.to_string());
            let problem = format!("{field} must be {expected}, but is {got}");
            DescriptionError { file, line, place, problem }
        })?;
        Ok((robot, warnings))
    }
}

/// Largest depth of the tree that every format can hold: in MJCF bodies nest.
const MAX_DEPTH: usize = 900;

fn shallow(parts: &Parts, origins: &Origins) -> Result<(), DescriptionError> {
    let mut depths = alloc::vec![0; parts.bodies.len()];
    for (index, body) in parts.bodies.iter().enumerate().skip(1) {
        // A parent after its child is refused by the validation.
        depths[index] = depths.get(body.parent).copied().unwrap_or(0) + 1;
        if depths[index] > MAX_DEPTH {
            let (file, line) = origins.of("body", index, "parent");
            let problem = format!("stands on {MAX_DEPTH} bodies one on the other: expected fewer");
            return Err(DescriptionError { file, line, place: format!("body `{}`", body.name), problem });
        }
    }
    Ok(())
}
