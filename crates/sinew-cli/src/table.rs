//! Tables for people.

use crate::output::bold;

/// Columns aligned by their widest cell: the first `left` columns to the left, the others to the right.
pub(crate) fn table(head: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let width: Vec<usize> = (0..head.len())
        .map(|c| {
            let cells = rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count());
            cells.chain([head[c].chars().count()]).max().unwrap_or(0)
        })
        .collect();
    let line = |cells: &[String]| -> String {
        let padded = cells.iter().enumerate().map(|(c, cell)| {
            let fill = " ".repeat(width[c].saturating_sub(cell.chars().count()));
            if c < left { format!("{cell}{fill}") } else { format!("{fill}{cell}") }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let head: Vec<String> = head.iter().map(ToString::to_string).collect();
    let mut text = bold(&line(&head)) + "\n";
    for row in rows {
        text += &(line(row) + "\n");
    }
    text
}

/// Four significant digits, or a dash where there is no number.
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

/// A fraction as a percentage with one digit.
pub(crate) fn percent(fraction: Option<f64>) -> String {
    fraction.filter(|v| v.is_finite()).map_or_else(|| "-".to_owned(), |v| format!("{:.1} %", 100.0 * v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits_and_what_is_no_number_is_a_dash() {
        assert_eq!(number(Some(123.456)), "123.5");
        assert_eq!(number(Some(0.001_234_56)), "0.001235");
        assert_eq!(number(Some(1.5e9)), "1.500e9");
        assert_eq!(number(Some(f64::NAN)), "-");
        assert_eq!(number(None), "-");
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let text =
            table(&["log", "n"], &[vec!["a".into(), "100".into()], vec!["bcde".into(), "2".into()]], 1);
        assert_eq!(text, "log     n\na     100\nbcde    2\n");
    }
}
