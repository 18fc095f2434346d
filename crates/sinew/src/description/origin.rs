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

impl Keys {
    pub(super) fn of(text: &str) -> Keys {
        let told = text.lines().enumerate().filter_map(|(index, line)| {
            let line = line.trim_start();
            let key = if line.starts_with("[[") { "[" } else { line.split_once('=')?.0.trim_end() };
            Some((index + 1, key.to_string()))
        });
        Keys(told.collect())
    }

    /// The line of a key, or of the one key that is this word and a unit, in the table whose head is on a
    /// line; of the head, where the table has no such key.
    pub(super) fn line(&self, head: usize, word: &str) -> usize {
        let from = self.0.partition_point(|(line, _)| *line <= head);
        let within = self.0[from..].iter().take_while(|(_, key)| key != "[");
        let is =
            |key: &str| key.strip_prefix(word).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
        within.into_iter().find(|(_, key)| !word.is_empty() && is(key)).map_or(head, |(line, _)| *line)
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

    pub(super) fn set_keys(&mut self, file: &str, text: &str) {
        self.keys.insert(file.to_string(), Keys::of(text));
    }

    /// File and line of a field of a part, or of the part where the field is not known.
    fn of(&self, kind: &'static str, index: usize, field: &str) -> (String, usize) {
        let Some((file, line)) = self.lines.get(&(kind, index)) else { return (self.file.clone(), 1) };
        let word = field.strip_prefix("its ").unwrap_or(field).replace(' ', "_");
        (file.clone(), self.keys.get(file).map_or(*line, |keys| keys.line(*line, &word)))
    }

    pub(super) fn set(&mut self, kind: &'static str, index: usize, file: &str, line: usize) {
        self.lines.insert((kind, index), (file.to_string(), line));
    }
}

impl Description {
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
            DescriptionError {
                file,
                line,
                place,
                problem: format!("{field} must be {expected}, but is {got}"),
            }
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
