//! Where in its files each part of a robot is described, for errors that show only when the robot is put together.

use super::Description;
use super::error::{DescriptionError, Warning};
use crate::body::Robot;
use crate::error::Error;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// File and line of parts, by kind and place in the list of the kind.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origins {
    /// The file that parts without a line are in.
    file: String,
    lines: BTreeMap<(&'static str, usize), (String, usize)>,
}

impl Origins {
    pub(super) fn new(file: &str) -> Origins {
        Origins { file: file.to_string(), lines: BTreeMap::new() }
    }

    pub(super) fn set(&mut self, kind: &'static str, index: usize, file: &str, line: usize) {
        self.lines.insert((kind, index), (file.to_string(), line));
    }
}

impl Description {
    /// The robot that is described.
    ///
    /// # Errors
    ///
    /// The first part that makes no sense, with file and line.
    pub fn robot(self) -> Result<(Robot, Vec<Warning>), DescriptionError> {
        let Description { parts, warnings, origins } = self;
        let robot = Robot::new(parts).map_err(|error| {
            let Error::Part { kind, index, name, field, expected, got } = error else {
                let place = "robot".to_string();
                return DescriptionError {
                    file: origins.file.clone(),
                    line: 1,
                    place,
                    problem: error.to_string(),
                };
            };
            let known = origins.lines.get(&(kind, index)).cloned();
            let (file, line) = known.unwrap_or_else(|| (origins.file.clone(), 1));
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
