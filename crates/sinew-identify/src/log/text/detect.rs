//! Detection of the dialect of a text table from its first lines.

use super::cell::{Cell, Delimiter, parse, split};
use super::dialect::{DELIMITERS, Dialect, HeadLine, drop_trailing_empty, is_comment, malformed};
use super::header::{find_header, names};
use crate::Error;
use crate::log::units::is_known;
use std::ops::Range;

/// Lines that the detection reads: in a table of three decimals the mark is told by a column that comes near
/// zero, which may take a stroke.
const HEAD_LINES: usize = 3000;
/// Begins LabVIEW's row of units, in the place of the column of time.
const LABVIEW_UNITS: &str = "Y_Unit_Label";
/// Ends each of the headers that LabVIEW writes above a table.
const LABVIEW_HEADER_END: &[u8] = b"***End_of_Header***";
/// The dialect of the table that starts with `head`; `whole` where `head` is all of it.
pub(super) fn detect(file: &str, head: &[u8], whole: bool) -> Result<Dialect, Error> {
    let skip_bytes = refuse_other_encodings(file, head)?;
    let body = &head[skip_bytes..];
    let terminator = if !body.contains(&b'\n') && body.contains(&b'\r') { b'\r' } else { b'\n' };
    let (mut content, comments) = sort_lines(body, terminator, whole);
    let labview = content.iter().rposition(|line| line.bytes.starts_with(LABVIEW_HEADER_END));
    let above: Vec<_> = labview.map_or_else(Vec::new, |end| content.drain(..=end).collect());
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
        first_row: Vec::new(),
        columns: Vec::new(),
        units: Vec::new(),
        findings: Vec::new(),
        bytes_per_row: 0.0,
    };
    find_header(file, &mut dialect, &content, &comments, width)?;
    labview_units(&mut dialect, &above);
    let above = comments.iter().filter(|comment| comment.number < dialect.data_line);
    if above.into_iter().any(|comment| says_simulated(comment.bytes)) {
        dialect.findings.push("its header says that the data are simulated".to_owned());
    }
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

/// Takes the units that are known from the header that LabVIEW writes, where it has one for every column.
fn labview_units(dialect: &mut Dialect, above: &[HeadLine<'_>]) {
    let rows = above.iter().map(|line| names(line.bytes, dialect.delimiter));
    let Some(mut row) = rows.into_iter().find(|row| row.first().is_some_and(|cell| cell == LABVIEW_UNITS))
    else {
        return;
    };
    row.truncate(dialect.columns.len());
    if row.len() == dialect.columns.len() && dialect.units.is_empty() {
        dialect.units =
            row.into_iter().map(|cell| if is_known(&cell) { cell } else { String::new() }).collect();
    }
}

/// Whether a comment begins with the word that marks what the twin writes.
fn says_simulated(comment: &[u8]) -> bool {
    let words = comment.trim_ascii_start().iter().skip_while(|b| b"#%/ \t".contains(b));
    words.take(9).map(u8::to_ascii_lowercase).eq(*b"simulated")
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
            if content.len() == HEAD_LINES {
                break;
            }
        }
    }
    (content, comments)
}

/// The delimiter under which the lines are most regular and most numeric, and the width it gives.
fn choose_delimiter(content: &[HeadLine<'_>]) -> (Delimiter, bool, usize) {
    let mut best = (Delimiter::Byte(b','), false, 1);
    let mut best_score = 0.0;
    for delimiter in DELIMITERS {
        for decimal_comma in [false, true] {
            let (width, score) = width_and_score(content, delimiter, decimal_comma);
            if width > 1 && score > best_score + 1e-9 {
                best_score = score;
                best = (delimiter, decimal_comma, width);
            }
        }
    }
    best
}

/// Most frequent width, and the fraction of lines of that width times the fraction of numbers in them; half
/// of it where the first line, as a rule the header, has another width: `0.01 sec` is one value under one
/// name.
fn width_and_score(content: &[HeadLine<'_>], delimiter: Delimiter, decimal_comma: bool) -> (usize, f64) {
    let mut fields = Vec::new();
    // The first line is as a rule the header: it counts only where it is alone.
    let skip = usize::from(content.len() > 1);
    split(content[0].bytes, delimiter, &mut fields);
    // A last column with a name and without values is a column.
    let named = if fields.last().is_some_and(|name| !name.is_empty()) { fields.len() } else { 0 };
    drop_trailing_empty(&mut fields);
    let header = fields.len();
    let rows: Vec<(usize, usize)> = content[skip..]
        .iter()
        .map(|line| {
            split(line.bytes, delimiter, &mut fields);
            if fields.len() != named {
                drop_trailing_empty(&mut fields);
            }
            let numeric = |r: &&Range<usize>| {
                matches!(
                    parse(&line.bytes[(*r).clone()], decimal_comma),
                    Cell::Number(_) | Cell::Missing | Cell::Infinite | Cell::Ambiguous
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
    let fraction = numeric as f64 / (regular.len() * width).max(1) as f64;
    let score = regular.len() as f64 / rows.len().max(1) as f64 * (fraction + 0.01);
    (width, if width == header || width == named { score } else { 0.5 * score })
}
