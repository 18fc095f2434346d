//! An error in a table that was read.

use std::fmt;

/// A place in a table and what is wrong there.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}{}: expected {expected}, got {got}", InColumn(.column.as_deref()))]
pub(crate) struct TableError {
    /// From 1.
    pub(crate) line: usize,
    pub(crate) column: Option<String>,
    pub(crate) expected: String,
    pub(crate) got: String,
}

struct InColumn<'a>(Option<&'a str>);

impl fmt::Display for InColumn<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |column| write!(f, ", column `{column}`"))
    }
}

impl TableError {
    pub(crate) fn in_line(line: usize, expected: impl Into<String>, got: impl Into<String>) -> Self {
        Self { line, column: None, expected: expected.into(), got: got.into() }
    }

    pub(crate) fn in_column(line: usize, column: &str, expected: impl Into<String>, got: &str) -> Self {
        Self { line, column: Some(column.to_owned()), expected: expected.into(), got: got.to_owned() }
    }
}
