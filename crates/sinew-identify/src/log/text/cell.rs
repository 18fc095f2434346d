//! Fields of a line, and what a cell holds.

use std::borrow::Cow;
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
    /// One mark that is a thousands separator or a decimal mark: `1,234`.
    Ambiguous,
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
    let plain = if decimal_comma && bytes.iter().any(|b| matches!(b, b',' | b'.')) {
        Cell::Text
    } else {
        number(bytes)
    };
    if plain == Cell::Text { marked(bytes, decimal_comma) } else { plain }
}

/// A number with a decimal comma or with thousands separators.
fn marked(bytes: &[u8], decimal_comma: bool) -> Cell {
    let (decimal, other) = if decimal_comma { (b',', b'.') } else { (b'.', b',') };
    let text = decoded(bytes);
    // No number worth reading is longer than this.
    if text.len() > 64 || !text.bytes().any(|b| b.is_ascii_digit()) {
        return Cell::Text;
    }
    let (whole, rest) = match text.split_once(char::from(decimal)) {
        Some((whole, rest)) => (whole, Some(rest)),
        None => (text.as_ref(), None),
    };
    let separator = whole.chars().find(|c| *c == char::from(other) || BLANK_SEPARATORS.contains(c));
    let joined = match separator {
        None => whole.to_owned(),
        Some(separator) if in_thousands(whole, separator) => {
            // A point or comma alone may as well be the decimal mark of another country.
            if separator == char::from(other) && rest.is_none() && whole.matches(separator).count() == 1 {
                return Cell::Ambiguous;
            }
            whole.replace(separator, "")
        }
        Some(_) => return Cell::Text,
    };
    let joined = rest.map_or_else(|| joined.clone(), |rest| format!("{joined}.{rest}"));
    number(joined.as_bytes())
}

/// Thousands separators that are no decimal mark anywhere: blanks, a no-break or thin one, and apostrophes.
const BLANK_SEPARATORS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];

/// Whether groups of three digits follow one to three, of which the first is no zero.
fn in_thousands(whole: &str, separator: char) -> bool {
    let mut groups = whole.trim_start_matches(['+', '-']).split(separator);
    let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    let first = groups
        .next()
        .is_some_and(|first| (1..=3).contains(&first.len()) && digits(first) && !first.starts_with('0'));
    first && groups.all(|group| group.len() == 3 && digits(group))
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
    decoded(bytes).trim().replace("\"\"", "\"")
}

/// UTF-8; where it is none, Latin-1, which Excel and LabVIEW write in Europe: `µm` must not become metres.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
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
    fn what_is_no_utf8_is_latin1() {
        assert_eq!(text(b"Kraft (\xb5m)"), "Kraft (µm)");
        assert_eq!(text("Kraft (µm)".as_bytes()), "Kraft (µm)");
        assert_eq!(parse(b"1\xa0234,5", true), Cell::Number(1234.5));
    }

    #[test]
    fn a_tab_between_tabs_is_an_empty_field() {
        assert_eq!(fields("1\t\t2", Delimiter::Byte(b'\t')), ["1", "", "2"]);
    }

    #[test]
    fn thousands_separators_are_read_where_they_can_be_nothing_else() {
        for (text, decimal_comma, number) in [
            ("1.234,5", true, 1234.5),
            ("1.234.567", true, 1_234_567.0),
            ("1,234.5", false, 1234.5),
            ("-12,345,678", false, -12_345_678.0),
            ("1 234,5", true, 1234.5),
            ("1\u{a0}234", false, 1234.0),
            ("1'234.5", false, 1234.5),
            ("-1,5e-3", true, -1.5e-3),
            ("0,123", true, 0.123),
            ("1,234", true, 1.234),
        ] {
            assert_eq!(parse(text.as_bytes(), decimal_comma), Cell::Number(number), "{text}");
        }
    }

    #[test]
    fn a_mark_with_two_meanings_is_not_guessed() {
        assert_eq!(parse(b"1.234", true), Cell::Ambiguous);
        assert_eq!(parse(b"1,234", false), Cell::Ambiguous);
        for text in ["1,5", "0,123", "1,2345", "1,23,456", "1,234,5", "1 23", "a,bcd"] {
            assert_eq!(parse(text.as_bytes(), false), Cell::Text, "{text}");
        }
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
