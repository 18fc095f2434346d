//! Errors and warnings about files of robots, machines and catalogues.

use alloc::string::String;

/// The first error in a file: its position, the value, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {place}: {problem}")]
pub struct DescriptionError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Element and attribute, or table and key.
    pub place: String,
    /// The value and what was expected.
    pub problem: String,
}

/// Content of a file that is ignored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// The ignored content and the consequence.
    pub what: String,
    /// Whether the body would move otherwise with it: no machine is made of such a body.
    pub changes_forces: bool,
}

impl core::fmt::Display for Warning {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.what)
    }
}
