//! Fields of a line, and what a cell holds.

use std::ops::Range;

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// One byte, such as a comma.
    Byte(u8),
    /// Any number of spaces and tabs.
    Whitespace,
}

impl Delimiter {
    /// Name for findings and errors.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Byte(b',') => "comma",
            Self::Byte(b';') => "semicolon",
            Self::Byte(b'\t') => "tab",
            Self::Byte(b'|') => "vertical bar",
            Self::Byte(_) => "byte",
            Self::Whitespace => "white space",
        }
    }
}

/// A cell that was asked to be a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    /// A finite number.
    Number(f64),
    /// Empty, NaN, NA, N/A or null.
    Missing,
    /// An infinity, or a number beyond f64.
    Infinite,
    /// Anything else.
    Text,
}

/// Cuts `line` at `delimiter` into `fields`, without quotes and surrounding blanks.
///
/// A quote opens only at the start of a field; a quote that never closes takes the rest of the line.
pub(super) fn split(line: &[u8], delimiter: Delimiter, fields: &mut Vec<Range<usize>>) {
    fields.clear();
    match delimiter {
        Delimiter::Byte(byte) => split_at_byte(line, byte, fields),
        Delimiter::Whitespace => split_at_blanks(line, fields),
    }
}

fn split_at_byte(line: &[u8], byte: u8, fields: &mut Vec<Range<usize>>) {
    let mut start = 0;
    loop {
        let first = skip_blanks(line, start, byte);
        if line.get(first) == Some(&b'"') {
            let close = closing_quote(line, first + 1);
            fields.push(trim(line, first + 1..close));
            let rest = (close + 1).min(line.len());
            match find(line, rest, byte) {
                Some(at) => start = at + 1,
                None => return,
            }
        } else {
            match find(line, start, byte) {
                Some(at) => {
                    fields.push(trim(line, start..at));
                    start = at + 1;
                }
                None => {
                    fields.push(trim(line, start..line.len()));
                    return;
                }
            }
        }
    }
}

fn split_at_blanks(line: &[u8], fields: &mut Vec<Range<usize>>) {
    let mut at = 0;
    while at < line.len() {
        if blank(line[at]) {
            at += 1;
        } else if line[at] == b'"' {
            let close = closing_quote(line, at + 1);
            fields.push(trim(line, at + 1..close));
            at = close + 1;
        } else {
            let end = (at..line.len()).find(|&i| blank(line[i])).unwrap_or(line.len());
            fields.push(at..end);
            at = end;
        }
    }
}

fn skip_blanks(line: &[u8], start: usize, delimiter: u8) -> usize {
    let mut at = start;
    while at < line.len() && blank(line[at]) && line[at] != delimiter {
        at += 1;
    }
    at
}

/// The quote that closes a field: one that is not doubled, or the end of the line.
fn closing_quote(line: &[u8], from: usize) -> usize {
    let mut at = from;
    while at < line.len() {
        if line[at] == b'"' {
            if line.get(at + 1) != Some(&b'"') {
                return at;
            }
            at += 1;
        }
        at += 1;
    }
    line.len()
}

fn find(line: &[u8], from: usize, byte: u8) -> Option<usize> {
    line.get(from..)?.iter().position(|&b| b == byte).map(|i| from + i)
}

fn blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t' || byte == b'\r'
}

fn trim(line: &[u8], mut range: Range<usize>) -> Range<usize> {
    while range.start < range.end && blank(line[range.start]) {
        range.start += 1;
    }
    while range.start < range.end && blank(line[range.end - 1]) {
        range.end -= 1;
    }
    range
}

/// What `bytes` hold; with `decimal_comma` a comma is the only decimal mark.
pub(super) fn parse(bytes: &[u8], decimal_comma: bool) -> Cell {
    if missing(bytes) {
        return Cell::Missing;
    }
    if !decimal_comma {
        return number(bytes);
    }
    // No number worth reading is longer than this.
    let mut copy = [0_u8; 64];
    let Some(copy) = copy.get_mut(..bytes.len()) else { return Cell::Text };
    for (to, &from) in copy.iter_mut().zip(bytes) {
        match from {
            b',' => *to = b'.',
            // A thousands mark or another convention: guessing would be off by a factor of 1000.
            b'.' => return Cell::Text,
            other => *to = other,
        }
    }
    number(copy)
}

fn number(bytes: &[u8]) -> Cell {
    let Ok(text) = std::str::from_utf8(bytes) else { return Cell::Text };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Cell::Number(value),
        Ok(value) if value.is_nan() => Cell::Missing,
        Ok(_) => Cell::Infinite,
        Err(_) => Cell::Text,
    }
}

/// Whether a cell is empty or marks a missing value.
pub(super) fn missing(bytes: &[u8]) -> bool {
    if bytes.len() > 4 {
        return false;
    }
    ["", "nan", "na", "n/a", "null"].iter().any(|word| bytes.eq_ignore_ascii_case(word.as_bytes()))
}

/// The text of a field, with doubled quotes made single.
pub(super) fn text(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.trim().replace("\"\"", "\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str, delimiter: Delimiter) -> Vec<String> {
        let mut ranges = Vec::new();
        split(line.as_bytes(), delimiter, &mut ranges);
        ranges.into_iter().map(|r| text(&line.as_bytes()[r])).collect()
    }

    #[test]
    fn quotes_hide_delimiters_and_double_quotes_are_one() {
        let got = fields(r#" "a,b" ,"say ""hi""", c ,"#, Delimiter::Byte(b','));
        assert_eq!(got, ["a,b", r#"say "hi""#, "c", ""]);
    }

    #[test]
    fn blanks_in_a_row_are_one_delimiter() {
        assert_eq!(fields("  1.5 \t -2   x ", Delimiter::Whitespace), ["1.5", "-2", "x"]);
    }

    #[test]
    fn a_tab_between_tabs_is_an_empty_field() {
        assert_eq!(fields("1\t\t2", Delimiter::Byte(b'\t')), ["1", "", "2"]);
    }

    #[test]
    fn a_thousands_mark_is_text_and_not_a_thousandth() {
        assert_eq!(parse(b"1.234,5", true), Cell::Text);
        assert_eq!(parse(b"1.234", true), Cell::Text);
        assert_eq!(parse(b"-1,5e-3", true), Cell::Number(-1.5e-3));
        assert_eq!(parse(b"1,5", false), Cell::Text);
    }

    #[test]
    fn what_is_beyond_f64_is_infinite_and_what_was_not_measured_is_missing() {
        assert_eq!(parse(b"1e999", false), Cell::Infinite);
        assert_eq!(parse(b"-Inf", false), Cell::Infinite);
        for word in ["", "NaN", "nan", "-nan", "NA", "n/a", "NULL"] {
            assert_eq!(parse(word.as_bytes(), false), Cell::Missing, "{word}");
        }
    }
}
