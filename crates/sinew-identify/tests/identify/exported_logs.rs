//! CSV as pandas writes it and as spreadsheets leave it: read as meant, or refused with line and remedy.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{Sample, csv, message, read, samples};
use sinew_identify::log::{ColumnOptions, ReadOptions, RequestedRoles, read_bytes};

const HEADER: &str = "t_s,tension_in_n,tension_out_n";

/// Rows of the header's columns with four decimals, cell by cell.
fn cells(scale: f64) -> Vec<[String; 3]> {
    let row = |[t, near, far]: Sample| [t, scale * near, scale * far].map(|x| format!("{x:.4}"));
    samples(60, 0.3).into_iter().map(row).collect()
}

fn joined(header: &str, rows: impl Iterator<Item = String>) -> String {
    format!("{header}\n{}\n", rows.collect::<Vec<_>>().join("\n"))
}

/// Inputs and far sides read from `text` are those of the plain table of the same numbers.
#[track_caller]
fn reads_as_plain(text: &str, scale: f64) {
    let plain = joined(HEADER, cells(scale).into_iter().map(|row| row.join(",")));
    let numbers = |text: &str| {
        let dataset = read(text, &RequestedRoles::default()).unwrap();
        let all = dataset.sequences.iter();
        all.flat_map(|s| {
            s.time_s.iter().chain(&s.inputs).chain(&s.far).map(|x| x.to_bits()).collect::<Vec<_>>()
        })
        .collect::<Vec<_>>()
    };
    assert_eq!(numbers(text), numbers(&plain), "{}", text.lines().take(3).collect::<Vec<_>>().join(" / "));
}

/// `1234.5678` with a separator of thousands and a decimal mark.
fn grouped(number: &str, separator: &str, decimal: &str) -> String {
    let (whole, rest) = number.split_once('.').unwrap();
    let at = whole.len().saturating_sub(3);
    let whole =
        if at > 0 { format!("{}{separator}{}", &whole[..at], &whole[at..]) } else { whole.to_owned() };
    format!("{whole}{decimal}{rest}")
}

#[test]
fn an_index_column_without_a_name_is_left() {
    let rows = cells(1.0).into_iter().enumerate().map(|(k, row)| format!("{k},{}", row.join(",")));
    let text = joined(&format!(",{HEADER}"), rows);
    reads_as_plain(&text, 1.0);
    let dataset = read(&text, &RequestedRoles::default()).unwrap();
    let index = dataset.columns.iter().find(|column| column.column == "col1").unwrap();
    assert_eq!(index.role, None, "{index:?}");
}

#[test]
fn a_last_column_without_values_is_read_whether_it_has_a_name_or_not() {
    let rows = || cells(1.0).into_iter().map(|row| row.join(",") + ",");
    for header in [HEADER.to_owned(), format!("{HEADER},"), format!("{HEADER},remark")] {
        reads_as_plain(&joined(&header, rows()), 1.0);
    }
    let rows = cells(1.0)
        .into_iter()
        .enumerate()
        .map(|(k, row)| row.join(",") + if k == 30 { ",slipped" } else { "," });
    reads_as_plain(&joined(&format!("{HEADER},remark"), rows), 1.0);
}

#[test]
fn quoted_headers_and_cells_are_read_as_plain_ones() {
    let quoted = |cells: &[String]| cells.iter().map(|c| format!("\"{c}\"")).collect::<Vec<_>>().join(",");
    let header: Vec<String> = HEADER.split(',').map(str::to_owned).collect();
    reads_as_plain(&joined(&quoted(&header), cells(1.0).iter().map(|row| quoted(row))), 1.0);
    let commas = cells(1.0).into_iter().map(|row| quoted(&row.map(|cell| cell.replace('.', ","))));
    reads_as_plain(&joined(&quoted(&header), commas), 1.0);
}

#[test]
fn thousands_separators_are_read_where_a_decimal_mark_stands_behind_them() {
    for (delimiter, separator, decimal) in
        [(";", ".", ","), (";", " ", ","), (";", "\u{a0}", ","), (";", "'", ".")]
    {
        let rows =
            cells(1000.0).into_iter().map(|row| row.map(|c| grouped(&c, separator, decimal)).join(delimiter));
        reads_as_plain(&joined(&HEADER.replace(',', delimiter), rows), 1000.0);
    }
    let quoted = |cell: String| format!("\"{}\"", grouped(&cell, ",", "."));
    reads_as_plain(&joined(HEADER, cells(1000.0).into_iter().map(|row| row.map(quoted).join(","))), 1000.0);
}

#[test]
fn a_single_mark_of_three_digits_is_refused_with_line_and_remedy() {
    let text = csv(&samples(60, 0.3));
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[20] = "0.19,\"6,234\",5.1".to_owned();
    let said = message(&(lines.join("\n") + "\n"), &RequestedRoles::default());
    for words in ["line 21", "tension_in_n", "6,234", "without thousands separators"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // In a file of decimal commas the point is the one that is not guessed.
    let european = joined(
        &HEADER.replace(',', ";"),
        cells(1.0).into_iter().enumerate().map(|(k, row)| {
            let row = row.join(";").replace('.', ",");
            if k == 30 { "0,3;6.234;5,1".to_owned() } else { row }
        }),
    );
    let said = message(&european, &RequestedRoles::default());
    assert!(said.contains("line 32") && said.contains("6.234") && said.contains("decimal point"), "{said}");
}

#[test]
fn a_table_in_which_no_cell_tells_the_mark_is_refused() {
    let row = |(k, [_, near, far]): (usize, Sample)| format!("{k};{near:.3};{far:.3}").replace('.', ",");
    let text = joined("t_s;tension_in_n;tension_out_n", samples(60, 0.3).into_iter().enumerate().map(row));
    let said = message(&text, &RequestedRoles::default());
    assert!(said.contains("line 2") && said.contains("thousands"), "{said}");
}

#[test]
fn one_cell_in_a_thousand_lines_tells_the_mark_of_all() {
    let lines = |told: &str| {
        let rows = (0..1200).map(|k| {
            let near = format!("{:.3}", 120.0 + 50.0 * (0.01 * f64::from(k)).sin());
            let far = if k == 1000 { told.to_owned() } else { near.clone() };
            format!("{near};{far}").replace('.', ",")
        });
        joined("tension_in_n;tension_out_n", rows)
    };
    let columns = ColumnOptions { rate_hz: Some(100.0), ..ColumnOptions::default() };
    let options = ReadOptions { far_required: true, columns, ..ReadOptions::default() };
    let read = |text: &str| read_bytes(&[("log.csv", text.as_bytes())], &RequestedRoles::default(), &options);
    let far = read(&lines("0.955")).unwrap().sequences[0].far[1000];
    assert!((far - 0.955).abs() < 1e-12, "{far}");
    assert!(read(&lines("100.955")).unwrap_err().to_string().contains("thousands"));
}

#[test]
fn the_line_by_which_a_spreadsheet_names_its_separator_is_no_header() {
    let rows = cells(1.0).into_iter().map(|row| row.join(";"));
    reads_as_plain(&format!("sep=;\r\n{}", joined(&HEADER.replace(',', ";"), rows)), 1.0);
}

#[test]
fn an_error_of_a_spreadsheet_is_named_with_its_line() {
    let text = csv(&samples(60, 0.3));
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[11] = "0.1,#DIV/0!,5.1".to_owned();
    let said = message(&(lines.join("\n") + "\n"), &RequestedRoles::default());
    assert!(said.contains("line 12") && said.contains("#DIV/0!"), "{said}");
}
