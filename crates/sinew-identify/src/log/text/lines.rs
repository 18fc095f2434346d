//! Lines of a stream, numbered, with a bound on their length.

use std::io::{self, BufRead};

/// No bench log has lines this long; what has is not a text table.
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;

/// A line as it was found.
pub(super) enum Line<'a> {
    /// A whole line, without its end.
    Whole(&'a [u8]),
    /// The last one, if nothing ends it: it may have been cut off while it was written.
    Last(&'a [u8]),
    /// Longer than [`MAX_LINE_BYTES`].
    TooLong,
    /// No more.
    End,
}

/// Reads lines one at a time into one buffer.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    terminator: u8,
    number: usize,
}

impl<R: BufRead> Lines<R> {
    /// Lines that end with `terminator`; a carriage return before a line feed is dropped.
    pub(super) fn new(reader: R, terminator: u8) -> Self {
        Self { reader, buffer: Vec::new(), terminator, number: 0 }
    }

    /// The number of the line last read, from 1.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// The next line.
    pub(super) fn next(&mut self) -> io::Result<Line<'_>> {
        self.buffer.clear();
        loop {
            let available = match self.reader.fill_buf() {
                Ok(available) => available,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(e),
            };
            if available.is_empty() {
                if self.buffer.is_empty() {
                    return Ok(Line::End);
                }
                self.number += 1;
                return Ok(Line::Last(without_return(&self.buffer)));
            }
            let end = available.iter().position(|&b| b == self.terminator);
            let taken = end.unwrap_or(available.len());
            if self.buffer.len() + taken > MAX_LINE_BYTES {
                self.number += 1;
                return Ok(Line::TooLong);
            }
            self.buffer.extend_from_slice(&available[..taken]);
            self.reader.consume(taken + usize::from(end.is_some()));
            if end.is_some() {
                self.number += 1;
                return Ok(Line::Whole(without_return(&self.buffer)));
            }
        }
    }
}

fn without_return(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}
