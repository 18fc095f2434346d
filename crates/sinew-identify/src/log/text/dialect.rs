//! How a text table is written, and what its first lines are cut into.

use super::cell::Delimiter;
use crate::Error;
use std::ops::Range;

/// How a text table is written.
#[derive(Debug, Clone)]
pub(in crate::log) struct Dialect {
    pub(super) delimiter: Delimiter,
    pub(super) decimal_comma: bool,
    /// Byte that ends a line.
    pub(super) terminator: u8,
    /// Bytes before the first line (a byte order mark).
    pub(super) skip_bytes: usize,
    /// The first line that holds data, from 1.
    pub(super) data_line: usize,
    /// The cells of that line.
    pub(super) first_row: Vec<String>,
    /// Column names.
    pub(super) columns: Vec<String>,
    /// Units row, if there is one: as many entries as columns.
    pub(super) units: Vec<String>,
    /// What was skipped, in words.
    pub(super) findings: Vec<String>,
    /// Mean length of a line of data.
    pub(super) bytes_per_row: f64,
}

/// In order of preference where several fit as well.
pub(super) const DELIMITERS: [Delimiter; 5] = [
    Delimiter::Byte(b'\t'),
    Delimiter::Byte(b';'),
    Delimiter::Byte(b','),
    Delimiter::Byte(b'|'),
    Delimiter::Whitespace,
];

/// One line of the head.
pub(super) struct HeadLine<'a> {
    /// From 1.
    pub(super) number: usize,
    /// Without its end.
    pub(super) bytes: &'a [u8],
}

pub(super) fn malformed(file: &str, line: Option<usize>, expected: &str, got: &str) -> Error {
    Error::Malformed { file: file.into(), line, expected: expected.into(), got: got.into() }
}

/// Whether a line is a comment: `#`, `%` or `//` come first.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
}

/// A delimiter at the end of every line makes no column.
pub(super) fn drop_trailing_empty(fields: &mut Vec<Range<usize>>) {
    if fields.len() > 1 && fields.last().is_some_and(|r| r.is_empty()) {
        fields.pop();
    }
}
