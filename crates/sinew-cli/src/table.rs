//! Tables and numbers as plain text for the terminal.

use crate::output::bold;
use comfy_table::{CellAlignment, Table, presets::NOTHING};

/// A table as text with a line per row: two blanks between columns, the first `left` columns aligned to the
/// left, the others to the right; the header is bold on a terminal.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING).set_header(header.iter().copied()).add_rows(rows);
    for (place, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        column.set_cell_alignment(if place < left { CellAlignment::Left } else { CellAlignment::Right });
    }
    let text = table.trim_fmt() + "\n";
    text.split_once('\n').map_or(text.clone(), |(header, rows)| bold(header) + "\n" + rows)
}

/// Four significant digits; all digits of the integer part below 1e6, scientific notation below 1e-4 and from
/// 1e6 on, a dash for a missing or non-finite number.
pub(crate) fn number(value: Option<f64>) -> String {
    let Some(value) = value.filter(|v| v.is_finite()) else { return "-".to_owned() };
    if value == 0.0 {
        return "0".to_owned();
    }
    #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a finite number is small")]
    let magnitude = value.abs().log10().floor() as i32;
    if (-4..6).contains(&magnitude) {
        let digits = usize::try_from(3 - magnitude).unwrap_or(0);
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

/// Unit of thousandths of joints' positions, whose units are `rad` or `m`.
pub(crate) fn thousandths<'a>(mut units: impl Iterator<Item = &'a str> + Clone) -> &'static str {
    let slides = units.clone().filter(|unit| *unit == "m").count();
    match (slides, units.all(|unit| unit == "m")) {
        (0, _) => "mrad",
        (_, true) => "mm",
        (_, false) => "mrad or mm",
    }
}

/// A fraction as a percentage with one decimal; as in [`number`] where it has five digits or is missing.
pub(crate) fn percent(fraction: Option<f64>) -> String {
    match fraction.filter(|fraction| fraction.is_finite()).map(|fraction| 100.0 * fraction) {
        None => "-".to_owned(),
        Some(small) if small.abs() < 1e4 => format!("{small:.1} %"),
        large => number(large) + " %",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits_and_missing_ones_are_a_dash() {
        assert_eq!(number(Some(123.456)), "123.5");
        assert_eq!(number(Some(0.001_234_56)), "0.001235");
        assert_eq!(number(Some(1.5e9)), "1.500e9");
        assert_eq!(number(Some(f64::NAN)), "-");
        assert_eq!(number(None), "-");
        assert_eq!(percent(Some(0.9997)), "100.0 %");
        assert_eq!(percent(Some(2e143)), "2.000e145 %");
        assert_eq!(percent(Some(f64::INFINITY)), "-");
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let text =
            table(&["log", "n"], &[vec!["a".into(), "100".into()], vec!["bcde".into(), "2".into()]], 1);
        assert_eq!(text, "log     n\na     100\nbcde    2\n");
    }
}
