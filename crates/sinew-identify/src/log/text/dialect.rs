//! How a text table is written: found from its first lines.

use super::cell::{Cell, Delimiter, parse, split};
use super::header::find_header;
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
    /// Column names.
    pub(super) columns: Vec<String>,
    /// Units row, if there is one: as many entries as columns.
    pub(super) units: Vec<String>,
    /// What was skipped, in words.
    pub(super) findings: Vec<String>,
    /// Mean length of a line of data.
    pub(super) bytes_per_row: f64,
}

/// Lines looked at.
const LOOKED_AT: usize = 300;
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

/// Finds how the table that starts with `head` is written; `whole` where `head` is all of it.
pub(super) fn find(file: &str, head: &[u8], whole: bool) -> Result<Dialect, Error> {
    let skip_bytes = refuse_other_encodings(file, head)?;
    let body = &head[skip_bytes..];
    let terminator = if !body.contains(&b'\n') && body.contains(&b'\r') { b'\r' } else { b'\n' };
    let (content, comments) = sort_lines(body, terminator, whole);
    if content.is_empty() {
        return Err(malformed(file, None, "a table with at least one row", "no line of data"));
    }
    let (delimiter, decimal_comma, width) = choose_delimiter(&content);
    let mut dialect = Dialect {
        delimiter,
        decimal_comma,
        terminator,
        skip_bytes,
        data_line: 0,
        columns: Vec::new(),
        units: Vec::new(),
        findings: Vec::new(),
        bytes_per_row: 0.0,
    };
    find_header(file, &mut dialect, &content, &comments, width)?;
    let data: Vec<_> = content.iter().filter(|l| l.number >= dialect.data_line).collect();
    let bytes: usize = data.iter().map(|l| l.bytes.len() + 1).sum();
    dialect.bytes_per_row = bytes as f64 / data.len().max(1) as f64;
    Ok(dialect)
}

/// Length of a UTF-8 byte order mark; other encodings and binary files are refused by name.
fn refuse_other_encodings(file: &str, head: &[u8]) -> Result<usize, Error> {
    if head.starts_with(&[0xFF, 0xFE]) || head.starts_with(&[0xFE, 0xFF]) {
        return Err(malformed(file, None, "text in UTF-8", "text in UTF-16: save it again as UTF-8"));
    }
    // Further down they are what a power failure leaves at the end of a file: a line that is cut off.
    if head.iter().take(1024).any(|&b| b == 0) {
        let expected = "a text table, MATLAB or Parquet file";
        return Err(malformed(file, None, expected, "a binary file of an unknown kind"));
    }
    Ok(if head.starts_with(&[0xEF, 0xBB, 0xBF]) { 3 } else { 0 })
}

pub(super) fn malformed(file: &str, line: Option<usize>, expected: &str, got: &str) -> Error {
    Error::Malformed { file: file.into(), line, expected: expected.into(), got: got.into() }
}

/// Lines with content and lines with comments.
fn sort_lines(body: &[u8], terminator: u8, whole: bool) -> (Vec<HeadLine<'_>>, Vec<HeadLine<'_>>) {
    let (mut content, mut comments) = (Vec::new(), Vec::new());
    let mut lines: Vec<&[u8]> = body.split(|&b| b == terminator).collect();
    if !whole && lines.len() > 1 {
        lines.pop();
    }
    for (i, line) in lines.into_iter().enumerate() {
        let bytes = line.strip_suffix(b"\r").unwrap_or(line);
        let head_line = HeadLine { number: i + 1, bytes };
        if is_comment(bytes) {
            comments.push(head_line);
        } else if !bytes.trim_ascii().is_empty() {
            content.push(head_line);
            if content.len() == LOOKED_AT {
                break;
            }
        }
    }
    (content, comments)
}

/// Whether a line is a comment: `#`, `%` or `//` come first.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
}

/// The delimiter under which the lines are most regular and most numeric, and the width it gives.
fn choose_delimiter(content: &[HeadLine<'_>]) -> (Delimiter, bool, usize) {
    let mut best = (Delimiter::Byte(b','), false, 1);
    let mut best_score = 0.0;
    for delimiter in DELIMITERS {
        for decimal_comma in [false, true] {
            if decimal_comma && delimiter == Delimiter::Byte(b',') {
                continue;
            }
            let (width, score) = judge(content, delimiter, decimal_comma);
            if width > 1 && score > best_score + 1e-9 {
                best_score = score;
                best = (delimiter, decimal_comma, width);
            }
        }
    }
    best
}

/// Most frequent width, and the share of lines of that width times the share of numbers in them.
fn judge(content: &[HeadLine<'_>], delimiter: Delimiter, decimal_comma: bool) -> (usize, f64) {
    let mut fields = Vec::new();
    // The first line is as a rule the header: it counts only where it is alone.
    let skip = usize::from(content.len() > 1);
    let rows: Vec<(usize, usize)> = content[skip..]
        .iter()
        .map(|line| {
            split(line.bytes, delimiter, &mut fields);
            drop_trailing_empty(&mut fields);
            let numeric = |r: &&Range<usize>| {
                matches!(
                    parse(&line.bytes[(*r).clone()], decimal_comma),
                    Cell::Number(_) | Cell::Missing | Cell::Infinite
                )
            };
            (fields.len(), fields.iter().filter(numeric).count())
        })
        .collect();
    let mut widths: Vec<usize> = rows.iter().map(|r| r.0).collect();
    widths.sort_unstable();
    let width = widths.chunk_by(|a, b| a == b).max_by_key(|run| run.len()).map_or(0, |run| run[0]);
    let regular: Vec<_> = rows.iter().filter(|r| r.0 == width).collect();
    let numeric: usize = regular.iter().map(|r| r.1).sum();
    let share = numeric as f64 / (regular.len() * width).max(1) as f64;
    let score = regular.len() as f64 / rows.len().max(1) as f64 * (share + 0.01);
    (width, score)
}

/// A delimiter at the end of every line makes no column.
pub(super) fn drop_trailing_empty(fields: &mut Vec<Range<usize>>) {
    if fields.len() > 1 && fields.last().is_some_and(|r| r.is_empty()) {
        fields.pop();
    }
}
