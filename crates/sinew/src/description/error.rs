//! What is wrong with a robot file, and what of it is passed over.

use alloc::string::String;

/// The first thing that is wrong with a robot file: where, what stands there, what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {place}: {problem}")]
pub struct DescriptionError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Element and attribute, or table and key.
    pub place: String,
    /// What stands there and what was expected.
    pub problem: String,
}

/// Something that a file says and that is passed over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// What is passed over and what follows from it.
    pub what: String,
}

impl core::fmt::Display for Warning {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.what)
    }
}
