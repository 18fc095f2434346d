//! The header of a text table: names, units, titles, or a comment that names the columns.

use super::cell::{Cell, Delimiter, missing, parse, split, text};
use super::dialect::{DELIMITERS, Dialect, HeadLine, drop_trailing_empty, malformed};
use crate::Error;
use crate::log::occurrences::counted;
use crate::log::units::is_unit_cell;
use std::ops::Range;

/// Fields of a line as text.
pub(super) fn names(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    let mut fields = Vec::new();
    split(line, delimiter, &mut fields);
    fields.into_iter().map(|r| text(&line[r])).collect()
}

fn numbers(dialect: &Dialect, line: &[u8]) -> usize {
    let mut fields = Vec::new();
    split(line, dialect.delimiter, &mut fields);
    let numeric = |r: &Range<usize>| {
        matches!(
            parse(&line[r.clone()], dialect.decimal_comma),
            Cell::Number(_) | Cell::Infinite | Cell::Ambiguous
        )
    };
    fields.into_iter().filter(numeric).count()
}

/// Sets columns, units and the first line of data.
pub(super) fn find_header(
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
    dialect.first_row = names(content[first_data].bytes, dialect.delimiter);
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
    // LabVIEW's last column is there in rows with a comment alone.
    let unsaid = |name: &String| name.is_empty() || name == "Comment";
    if found.len() == width + 1 && found.last().is_some_and(unsaid) {
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
        // A second line of names, or a title above each of them, holds hardly any unit.
        (Some(_), Some(units)) if mostly_units(&units) => (last - 1, Some(units)),
        _ => (last, None),
    };
    dialect.columns = header(file, dialect, &above[header_at], width)?;
    if let Some(units) = units {
        dialect.findings.push(format!("line {} was read as a row of units", above[last].number));
        dialect.units = units;
    }
    if header_at > 0 {
        dialect.findings.push(format!("skipped {} above the header", counted(header_at, "line")));
    }
    Ok(())
}

/// Whether at least half of what is written in a line are units.
fn mostly_units(cells: &[String]) -> bool {
    let written = cells.iter().filter(|cell| !cell.is_empty()).count();
    2 * cells.iter().filter(|cell| !cell.is_empty() && is_unit_cell(cell)).count() >= written
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
        [.., first, second] if second.iter().all(|name| is_unit_cell(name)) => {
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
