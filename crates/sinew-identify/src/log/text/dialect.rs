//! How a text table is written: found from its first lines.

use super::cell::{Cell, Delimiter, missing, parse, split, text};
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
const DELIMITERS: [Delimiter; 5] = [
    Delimiter::Byte(b'\t'),
    Delimiter::Byte(b';'),
    Delimiter::Byte(b','),
    Delimiter::Byte(b'|'),
    Delimiter::Whitespace,
];

/// One line of the head.
struct HeadLine<'a> {
    number: usize,
    bytes: &'a [u8],
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
    if head.contains(&0) {
        let expected = "a text table, MATLAB or Parquet file";
        return Err(malformed(file, None, expected, "a binary file of an unknown kind"));
    }
    Ok(if head.starts_with(&[0xEF, 0xBB, 0xBF]) { 3 } else { 0 })
}

fn malformed(file: &str, line: Option<usize>, expected: &str, got: &str) -> Error {
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

/// Fields of a line as text.
fn names(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    let mut fields = Vec::new();
    split(line, delimiter, &mut fields);
    fields.into_iter().map(|r| text(&line[r])).collect()
}

fn numbers(dialect: &Dialect, line: &[u8]) -> usize {
    let mut fields = Vec::new();
    split(line, dialect.delimiter, &mut fields);
    let numeric = |r: &Range<usize>| {
        matches!(parse(&line[r.clone()], dialect.decimal_comma), Cell::Number(_) | Cell::Infinite)
    };
    fields.into_iter().filter(numeric).count()
}

/// Sets columns, units and the first line of data.
fn find_header(
    file: &str,
    dialect: &mut Dialect,
    content: &[HeadLine<'_>],
    comments: &[HeadLine<'_>],
    width: usize,
) -> Result<(), Error> {
    // Whatever holds a number is data: names of columns are never numbers alone.
    let first_data = content.iter().enumerate().position(|(i, line)| {
        let found = numbers(dialect, line.bytes);
        found > 0 && !titled(dialect, line, width) || i > 0 && all_missing(dialect, line)
    });
    let Some(first_data) = first_data else {
        let line = content[0].number;
        return Err(malformed(file, Some(line), "numbers below the header", "no number at all"));
    };
    dialect.data_line = content[first_data].number;
    let above = &content[..first_data];
    match above.len() {
        0 => commented_header(dialect, comments, width),
        1 => dialect.columns = header(file, dialect, &above[0], width)?,
        _ => header_and_units(file, dialect, above, width)?,
    }
    for (i, name) in dialect.columns.iter_mut().enumerate() {
        if name.is_empty() {
            *name = format!("col{}", i + 1);
        }
    }
    Ok(())
}

/// Whether every cell of a line is empty or NaN.
fn all_missing(dialect: &Dialect, line: &HeadLine<'_>) -> bool {
    names(line.bytes, dialect.delimiter).iter().all(|name| missing(name.as_bytes()))
}

/// Whether a line above the table holds a number by accident, such as a date or a version in a title.
fn titled(dialect: &Dialect, line: &HeadLine<'_>, width: usize) -> bool {
    let mut fields = Vec::new();
    split(line.bytes, dialect.delimiter, &mut fields);
    drop_trailing_empty(&mut fields);
    fields.len() != width && numbers(dialect, line.bytes) < fields.len()
}

/// The names in a header line, checked against the width of the data.
fn header(file: &str, dialect: &Dialect, line: &HeadLine<'_>, width: usize) -> Result<Vec<String>, Error> {
    let mut found = names(line.bytes, dialect.delimiter);
    if found.len() == width + 1 && found.last().is_some_and(String::is_empty) {
        found.pop();
    }
    if found.len() == width {
        return Ok(found);
    }
    Err(malformed(
        file,
        Some(line.number),
        &format!(
            "{width} column names, as many as the data have columns ({} between them)",
            dialect.delimiter.name()
        ),
        &format!("{}", found.len()),
    ))
}

/// Several lines above the data: titles, a header, perhaps a units row.
fn header_and_units(
    file: &str,
    dialect: &mut Dialect,
    above: &[HeadLine<'_>],
    width: usize,
) -> Result<(), Error> {
    let fits = |line: &HeadLine<'_>| header(file, dialect, line, width).ok();
    let last = above.len() - 1;
    let (header_at, units) = match (fits(&above[last - 1]), fits(&above[last])) {
        (Some(_), Some(units)) => (last - 1, Some(units)),
        _ => (last, None),
    };
    dialect.columns = header(file, dialect, &above[header_at], width)?;
    if let Some(units) = units {
        dialect.findings.push(format!("line {} was read as a row of units", above[last].number));
        dialect.units = units;
    }
    if header_at > 0 {
        dialect.findings.push(format!("{header_at} lines above the header were skipped"));
    }
    Ok(())
}

/// No header among the lines: perhaps a comment names the columns, else they are numbered.
fn commented_header(dialect: &mut Dialect, comments: &[HeadLine<'_>], width: usize) {
    let above: Vec<Vec<String>> = comments
        .iter()
        .filter(|c| c.number < dialect.data_line)
        .filter_map(|c| commented_names(dialect, c.bytes, width))
        .collect();
    match above.as_slice() {
        [] => {
            dialect.columns = (1..=width).map(|i| format!("col{i}")).collect();
            dialect.findings.push(format!("there is no header: the columns are named col1 to col{width}"));
        }
        [.., first, second] if second.iter().all(|name| super::super::names::is_unit(name)) => {
            dialect.columns = first.clone();
            dialect.units = second.clone();
        }
        [.., only] => dialect.columns = only.clone(),
    }
}

/// The names in a comment, if there are as many as columns and none is a number.
fn commented_names(dialect: &Dialect, comment: &[u8], width: usize) -> Option<Vec<String>> {
    let marks: &[u8] = b"#%/";
    let start = comment.iter().position(|b| !marks.contains(b) && !b.is_ascii_whitespace())?;
    let inner = &comment[start..];
    std::iter::once(dialect.delimiter).chain(DELIMITERS).find_map(|delimiter| {
        let mut found = names(inner, delimiter);
        if found.len() == width + 1 && found.last().is_some_and(String::is_empty) {
            found.pop();
        }
        let named = |name: &String| !missing(name.as_bytes()) && name.parse::<f64>().is_err();
        (found.len() == width && found.iter().all(named)).then_some(found)
    })
}
