//! A text table, streamed: only the requested columns are stored.

use super::cell::{Cell, decoded, missing, parse, split};
use super::detect::detect;
use super::dialect::{Dialect, drop_trailing_empty, is_comment};
use super::lines::{Line, Lines, MAX_LINE_BYTES};
use super::stamp::{Stopwatch, is_stamp};
use crate::Error;
use crate::log::memory_limit::{MEMORY_LIMIT_BYTES, bytes_per_row};
use crate::log::occurrences::counted;
use crate::log::table::{Requested, Table, TableBuilder};
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::PathBuf;

/// Bytes from which the dialect is found.
const HEAD_BYTES: u64 = 256 << 10;

/// Where the text comes from.
enum Origin {
    File(PathBuf),
    Bytes(Vec<u8>),
}

/// A text table of which the columns are known.
pub(in crate::log) struct TextLog {
    file: String,
    origin: Origin,
    dialect: Dialect,
    bytes: u64,
}

impl TextLog {
    /// Detects the dialect of a file.
    pub(in crate::log) fn open(file: &str, path: PathBuf) -> Result<Self, Error> {
        let unreadable = |source| Error::Unreadable { file: file.to_owned(), source };
        let handle = File::open(&path).map_err(unreadable)?;
        let bytes = handle.metadata().map_err(unreadable)?.len();
        let mut head = Vec::new();
        handle.take(HEAD_BYTES).read_to_end(&mut head).map_err(unreadable)?;
        let dialect = detect(file, &head, (head.len() as u64) < HEAD_BYTES)?;
        Ok(Self { file: file.to_owned(), origin: Origin::File(path), dialect, bytes })
    }

    /// Detects the dialect of a log in memory.
    pub(in crate::log) fn from_bytes(file: &str, bytes: Vec<u8>) -> Result<Self, Error> {
        let head = &bytes[..bytes.len().min(HEAD_BYTES as usize)];
        let dialect = detect(file, head, head.len() == bytes.len())?;
        let length = bytes.len() as u64;
        Ok(Self { file: file.to_owned(), origin: Origin::Bytes(bytes), dialect, bytes: length })
    }

    /// Column names.
    pub(in crate::log) fn columns(&self) -> &[String] {
        &self.dialect.columns
    }

    /// The unit of a column from a units row, or an empty string.
    pub(in crate::log) fn unit(&self, column: usize) -> &str {
        self.dialect.units.get(column).map_or("", String::as_str)
    }

    /// Whether the first cell of a column states time by itself: a stamp, a clock, a duration with its unit.
    pub(in crate::log) fn is_stamped(&self, column: usize) -> bool {
        self.dialect.first_row.get(column).is_some_and(|cell| is_stamp(cell.as_bytes()))
    }

    /// Estimated number of rows.
    pub(in crate::log) fn rows(&self) -> u64 {
        (self.bytes as f64 / self.dialect.bytes_per_row.max(2.0)) as u64
    }

    /// Reads what is `requested`.
    pub(in crate::log) fn read(self, requested: &Requested) -> Result<Table, Error> {
        let Self { file, origin, dialect, .. } = self;
        let skip = dialect.skip_bytes as u64;
        match origin {
            Origin::File(path) => {
                let unreadable = |source| Error::Unreadable { file: file.clone(), source };
                let mut handle = File::open(&path).map_err(unreadable)?;
                handle.seek(SeekFrom::Start(skip)).map_err(unreadable)?;
                stream(&file, BufReader::with_capacity(1 << 17, handle), &dialect, requested)
            }
            Origin::Bytes(bytes) => {
                let mut cursor = Cursor::new(bytes);
                cursor.set_position(skip);
                stream(&file, cursor, &dialect, requested)
            }
        }
    }
}

/// A line cut into fields, with the place for messages.
struct Row<'a> {
    file: &'a str,
    line: usize,
    bytes: &'a [u8],
    fields: &'a [Range<usize>],
    dialect: &'a Dialect,
}

impl Row<'_> {
    fn cell(&self, column: usize) -> &[u8] {
        self.fields.get(column).and_then(|r| self.bytes.get(r.clone())).unwrap_or_default()
    }

    /// Seconds since the first stamp.
    fn seconds(&self, column: usize, watch: &mut Stopwatch) -> Result<f64, Error> {
        let cell = self.cell(column);
        if missing(cell) {
            return Ok(f64::NAN);
        }
        let Some(elapsed) = watch.nanoseconds(cell) else {
            return Err(Error::NotATime {
                file: self.file.to_owned(),
                line: self.line,
                column: self.dialect.columns[column].clone(),
                value: decoded(cell).chars().take(60).collect(),
            });
        };
        Ok(elapsed as f64 / 1e9)
    }

    fn number(&self, column: usize) -> Result<f64, Error> {
        let cell = self.cell(column);
        let place = || {
            let short: String = decoded(cell).chars().take(60).collect();
            (self.file.to_owned(), self.line, self.dialect.columns[column].clone(), short)
        };
        match parse(cell, self.dialect.decimal_comma) {
            Cell::Number(value) => Ok(value),
            Cell::Missing => Ok(f64::NAN),
            Cell::Infinite => {
                let (file, line, column, value) = place();
                Err(Error::NotFinite { file, line, column, value })
            }
            Cell::Ambiguous => {
                let (file, line, column, value) = place();
                Err(Error::AmbiguousNumber { file, line, column, value })
            }
            Cell::Text => {
                let (file, line, column, value) = place();
                Err(Error::NotANumber { file, line, column, value })
            }
        }
    }
}

fn stream(
    file: &str,
    reader: impl BufRead,
    dialect: &Dialect,
    requested: &Requested,
) -> Result<Table, Error> {
    let mut lines = Lines::new(reader, dialect.terminator);
    let mut builder = TableBuilder::new(requested);
    let mut fields = Vec::new();
    let mut findings = dialect.findings.clone();
    let mut comments = 0;
    let mut watch = Stopwatch::default();
    let width = dialect.columns.len();
    let max_rows = MEMORY_LIMIT_BYTES as usize / bytes_per_row(requested.numbers.len());
    loop {
        let number = lines.number() + 1;
        let unreadable = |source| Error::Unreadable { file: file.to_owned(), source };
        let (bytes, last) = match lines.next().map_err(unreadable)? {
            Line::Whole(bytes) => (bytes, false),
            Line::Last(bytes) => (bytes, true),
            Line::End => break,
            Line::TooLong => return Err(too_long(file, number)),
        };
        if number < dialect.data_line || bytes.trim_ascii().is_empty() {
            continue;
        }
        if is_comment(bytes) {
            comments += 1;
            continue;
        }
        split(bytes, dialect.delimiter, &mut fields);
        if fields.len() == width + 1 {
            drop_trailing_empty(&mut fields);
        }
        if fields.len() != width {
            if last && fields.len() < width && builder.rows() > 0 {
                findings.push(format!("line {number}, the last, is cut off and was dropped"));
                continue;
            }
            return Err(wrong_width(file, number, width, fields.len()));
        }
        if builder.rows() >= max_rows {
            // The estimate before reading can be too low where rows become shorter or the file grows.
            return Err(Error::TooLarge {
                file: file.to_owned(),
                needed_mb: MEMORY_LIMIT_BYTES >> 20,
                limit_mb: MEMORY_LIMIT_BYTES >> 20,
            });
        }
        let row = Row { file, line: number, bytes, fields: &fields, dialect };
        store(&row, requested, &mut watch, &mut builder)?;
    }
    if comments > 0 {
        findings.push(format!("skipped {} among the data", counted(comments, "comment line")));
    }
    Ok(builder.finish(findings))
}

fn store(
    row: &Row<'_>,
    requested: &Requested,
    watch: &mut Stopwatch,
    builder: &mut TableBuilder,
) -> Result<(), Error> {
    builder.begin(row.line);
    if let Some(column) = requested.trial {
        builder.trial(row.cell(column));
    }
    if let Some(column) = requested.group {
        builder.group(row.cell(column));
    }
    for (k, &column) in requested.numbers.iter().enumerate() {
        let stamped = requested.stamped == Some(column);
        builder.number(k, if stamped { row.seconds(column, watch)? } else { row.number(column)? });
    }
    builder.candidates(|column| Cow::Borrowed(row.cell(column)));
    Ok(())
}

fn too_long(file: &str, line: usize) -> Error {
    Error::Malformed {
        file: file.into(),
        line: Some(line),
        expected: "a line of a text table".into(),
        got: format!("more than {MAX_LINE_BYTES} bytes without a line end"),
    }
}

fn wrong_width(file: &str, line: usize, expected: usize, got: usize) -> Error {
    Error::Malformed {
        file: file.into(),
        line: Some(line),
        expected: format!("{expected} fields, as in the rows before"),
        got: format!("{got}"),
    }
}
