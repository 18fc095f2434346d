//! Constants, texts and comments of C.

use std::fmt::Write;

/// A number as a literal that gives the same bits: decimal where it is a small whole number, else
/// hexadecimal.
pub(crate) fn double(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e6 {
        return format!("{x:.1}");
    }
    let bits = x.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i64, bits & ((1 << 52) - 1));
    let (lead, power) = if exponent == 0 { (0, -1022) } else { (1, exponent - 1023) };
    let digits = format!("{fraction:013x}");
    let digits = digits.trim_end_matches('0');
    let sign = if x.is_sign_negative() { "-" } else { "" };
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{lead}{point}{digits}p{power:+}")
}

/// The same in single precision.
pub(super) fn single(x: f32) -> String {
    double(f64::from(x)) + "f"
}

/// `static const double NAME = X;`
pub(super) fn scalar(name: &str, x: f64) -> String {
    format!("static const double {name} = {};\n", double(x))
}

/// An array of numbers; `values` has at least one.
pub(super) fn array(name: &str, values: &[f64]) -> String {
    let list: Vec<String> = values.iter().map(|x| double(*x)).collect();
    format!("static const double {name}[{}] = {{\n{}\n}};\n", values.len(), wrapped(&list, "    "))
}

/// An array of rows of eight, one row a line.
pub(super) fn rows(kind: &str, name: &str, rows: &[Vec<String>]) -> String {
    let lines: Vec<String> =
        rows.iter().map(|row| format!("{{{}}}", wrapped(row, "     ").trim_start())).collect();
    format!("static const {kind} {name}[{}][8] = {{\n    {}\n}};\n", rows.len(), lines.join(",\n    "))
}

/// An array of tables of rows of eight.
pub(super) fn tables(kind: &str, name: &str, width: usize, rows: &[Vec<String>]) -> String {
    let table = |rows: &[Vec<String>]| {
        let lines = rows.iter().map(|row| format!("{{{}}}", wrapped(row, "      ").trim_start()));
        format!("    {{{}}}", lines.collect::<Vec<_>>().join(",\n     "))
    };
    let all: Vec<String> = rows.chunks(width).map(table).collect();
    format!("static const {kind} {name}[{}][{width}][8] = {{\n{}\n}};\n", all.len(), all.join(",\n"))
}

/// Items in lines of at most 108 characters.
fn wrapped(items: &[String], indent: &str) -> String {
    let mut lines = vec![indent.to_owned()];
    for (k, item) in items.iter().enumerate() {
        let item = if k + 1 < items.len() { format!("{item},") } else { item.clone() };
        let line = lines.last_mut().filter(|line| line.len() + item.len() < 108);
        match line {
            Some(line) if line.len() > indent.len() => *line += &format!(" {item}"),
            Some(line) => *line += &item,
            None => lines.push(format!("{indent}{item}")),
        }
    }
    lines.join("\n")
}

/// Text for a comment: nothing in it ends the comment, opens another, or is more than printable ASCII.
pub(super) fn comment(text: &str) -> String {
    let mut safe = String::new();
    for c in text.chars() {
        match c {
            ' '..='~' if !(matches!(c, '*' | '/') && safe.ends_with(['*', '/'])) => safe.push(c),
            ' '..='~' => safe.extend([' ', c]),
            _ => safe.extend(c.escape_unicode()),
        }
    }
    safe
}

/// A string literal with these bytes; no trigraph arises.
pub(super) fn string(text: &str) -> String {
    let mut literal = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' | b'?' => literal.extend(['\\', char::from(byte)]),
            b' '..=b'~' => literal.push(char::from(byte)),
            // Three octal digits: a digit that follows is not taken for one more.
            _ => {
                let _ = write!(literal, "\\{byte:03o}");
            }
        }
    }
    literal + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_are_exact_and_short_where_numbers_are_whole() {
        let cases = [
            (1.0, "1.0"),
            (-0.0, "-0.0"),
            (-3.0, "-3.0"),
            (0.1, "0x1.999999999999ap-4"),
            (f64::MIN_POSITIVE, "0x1p-1022"),
            (5e-324, "0x0.0000000000001p-1022"),
            (1e300, "0x1.7e43c8800759cp+996"),
            (0.5, "0x1p-1"),
        ];
        for (x, literal) in cases {
            assert_eq!(double(x), literal);
        }
        assert_eq!(single(0.1), "0x1.99999ap-4f");
    }

    #[test]
    fn names_of_columns_neither_end_a_comment_nor_leave_a_string() {
        assert_eq!(comment("F */ int x; /* [N]"), "F * / int x; / * [N]");
        assert_eq!(comment("Kraft \u{e4}\n\\"), "Kraft \\u{e4}\\u{a}\\");
        assert_eq!(string("a\"b\\c??/\u{e4}1"), "\"a\\\"b\\\\c\\?\\?/\\303\\2441\"");
    }
}
