//! Text tables in every dialect a bench program writes: the same samples come out.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{Sample, csv, options, read, samples};
use proptest::prelude::*;
use sinew_identify::log::{Dataset, RequestedRoles, read_bytes};
use std::fmt::Write as _;

fn plain() -> RequestedRoles {
    RequestedRoles::default()
}

fn table(header: &str, samples: &[Sample], delimiter: &str, end: &str) -> String {
    let mut text = String::from(header);
    for [t, near, far] in samples {
        write!(text, "{t}{delimiter}{near}{delimiter}{far}{end}").unwrap();
    }
    text
}

#[track_caller]
fn same_samples(dataset: &Dataset, expected: &[Sample]) {
    let got: Vec<Sample> = dataset
        .sequences
        .iter()
        .flat_map(|s| (0..s.row.len()).map(|i| [s.time_s[i], s.inputs[i], s.far[i]]))
        .collect();
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        for k in 0..3 {
            assert_eq!(got[k].to_bits(), expected[k].to_bits(), "{got:?} {expected:?}");
        }
    }
}

#[track_caller]
fn reads_as(text: &str, expected: &[Sample]) -> Dataset {
    let dataset = read(text, &plain()).unwrap();
    same_samples(&dataset, expected);
    dataset
}

#[test]
fn every_delimiter_is_found() {
    let samples = samples(60, 0.3);
    for delimiter in [",", ";", "\t", "|", " ", "   ", ", ", " ; ", " \t "] {
        let header = ["t_s", "tension_in_n", "tension_out_n"].join(delimiter) + "\n";
        reads_as(&table(&header, &samples, delimiter, "\n"), &samples);
    }
}

#[test]
fn a_duration_with_a_blank_is_one_value() {
    let samples = samples(60, 0.3);
    for delimiter in [",", ";", "\t"] {
        let header = ["t", "tension_in_n", "tension_out_n"].join(delimiter) + "\n";
        let rows = table("", &samples, delimiter, "\n");
        let rows: String =
            rows.lines().map(|row| row.replacen(delimiter, &format!(" sec{delimiter}"), 1) + "\n").collect();
        let found = &read(&(header + &rows), &plain()).unwrap().sequences[0];
        assert!(found.far.iter().eq(samples.iter().map(|[_, _, far]| far)));
        // Durations are read to the nanosecond.
        assert!(found.time_s.iter().zip(&samples).all(|(read, [time, ..])| (read - time).abs() < 1e-9));
    }
}

#[test]
fn a_decimal_comma_is_found_where_the_comma_does_not_delimit() {
    let samples = samples(60, 0.3);
    for delimiter in [";", "\t", "|", " "] {
        let header = ["t_s", "tension_in_n", "tension_out_n"].join(delimiter) + "\n";
        reads_as(&table(&header, &samples, delimiter, "\n").replace('.', ","), &samples);
    }
}

#[test]
fn line_ends_and_byte_order_marks_are_no_content() {
    let samples = samples(60, 0.3);
    for end in ["\n", "\r\n", "\r"] {
        let header = format!("\u{feff}t_s,tension_in_n,tension_out_n{end}");
        reads_as(&table(&header, &samples, ",", end), &samples);
    }
    let text = csv(&samples);
    reads_as(text.trim_end(), &samples);
}

#[test]
fn a_delimiter_at_the_end_of_every_line_makes_no_column() {
    let samples = samples(60, 0.3);
    reads_as(&table("t_s,tension_in_n,tension_out_n,\n", &samples, ",", ",\n"), &samples);
    reads_as(&table("t_s,tension_in_n,tension_out_n\n", &samples, ",", ",\n"), &samples);
}

#[test]
fn comments_are_skipped_and_counted() {
    let samples = samples(60, 0.3);
    let mut text = String::from("# bench 3\n% 2026-11-20\n// run 7\n");
    for (i, line) in csv(&samples).lines().enumerate() {
        text += line;
        text += if i == 30 { "\n# stopped for a moment\n\n" } else { "\n" };
    }
    let dataset = reads_as(&text, &samples);
    assert_eq!(dataset.logs[0].findings, ["skipped 1 comment line among the data"]);
    assert_eq!(dataset.sequences[0].row[29..32], [34, 37, 38], "lines as an editor counts them");
}

#[test]
fn a_comment_that_names_the_columns_is_the_header() {
    let samples = samples(60, 0.3);
    for header in [
        "% t_s tension_in_n tension_out_n\n",
        "%% t_s, tension_in_n, tension_out_n\n",
        "# made by bench 3\n#t_s\ttension_in_n\ttension_out_n\n",
        "# t_s tension_in_n tension_out_n\n# s N N\n",
        "// t_s;tension_in_n;tension_out_n\n",
    ] {
        reads_as(&table(header, &samples, " ", "\n"), &samples);
    }
}

#[test]
fn a_units_row_is_reported_and_gives_the_unit_of_time() {
    let samples = samples(60, 0.3);
    let text = table("time,tension_in_n,tension_out_n\ns,N,N\n", &samples, ",", "\n");
    let dataset = reads_as(&text, &samples);
    assert_eq!(dataset.logs[0].findings, ["line 2 was read as a row of units"]);
    let text = table("time,tension_in_n,tension_out_n\n[ms],[N],[N]\n", &samples, ",", "\n");
    let dataset = read(&text, &plain()).unwrap();
    assert!((dataset.sequences[0].time_s[50] - 0.5e-3).abs() < 1e-12);
}

#[test]
fn time_is_in_seconds_whatever_its_suffix_says() {
    let samples = samples(60, 0.3);
    for (name, scale) in [("t_ms", 1e-3), ("time_us", 1e-6), ("Time (ms)", 1e-3), ("t_s", 1.0)] {
        let text = csv(&samples).replace("t_s", name);
        let dataset = read(&text, &plain()).unwrap();
        let got = dataset.sequences[0].time_s[59];
        assert!((got - 0.59 * scale).abs() < 1e-12, "{name}: {got}");
    }
}

#[test]
fn units_in_latin1_are_those_of_utf8() {
    let samples = samples(60, 0.3);
    let utf8 = table("Zeit (s);x (µm);tension_out_n\n", &samples, ";", "\n");
    let latin1: Vec<u8> = utf8.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let flags = RequestedRoles { motion: vec!["x (µm)".into()], ..plain() };
    for bytes in [utf8.into_bytes(), latin1] {
        let dataset = read_bytes(&[("day.csv", &bytes)], &flags, &options()).unwrap();
        assert_eq!(dataset.unit("x (µm)"), "um");
    }
}

#[test]
fn a_second_line_of_names_is_no_row_of_units() {
    let samples = samples(60, 0.3);
    let text = table("near,near,far\nt_s,tension_in_n,tension_out_n\n", &samples, ",", "\n");
    let dataset = reads_as(&text, &samples);
    assert_eq!(dataset.logs[0].findings, ["skipped 1 line above the header"]);
}

#[test]
fn the_two_headers_of_labview_stand_above_the_table() {
    let samples = samples(60, 0.3);
    let header = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\nDate\t2026/03/01\n***End_of_Header***\t\n\t\n\
        Channels\t2\t\t\nSamples\t60\t60\t\nY_Unit_Label\tN\tN\t\nX0\t0.0E+0\t0.0E+0\t\n***End_of_Header***\t\t\t\n\
        X_Value\tLC_prox\tLC_dist\tComment\n";
    let flags = RequestedRoles { far: Some("LC_dist".into()), effort: vec!["LC_prox".into()], ..plain() };
    for end in ["\n", "\t\n"] {
        let dataset = read(&table(header, &samples, "\t", end), &flags).unwrap();
        same_samples(&dataset, &samples);
        assert_eq!(dataset.unit("LC_prox"), "N");
    }
}

#[test]
fn quoted_names_and_cells_are_plain() {
    let samples = samples(60, 0.3);
    let text = table("\"t_s\",\"tension, in (N)\",\"Tension out (N)\"\n", &samples, ",", "\n");
    let flags = RequestedRoles { effort: vec!["tension, in (N)".into()], ..plain() };
    let dataset = read(&text, &flags).unwrap();
    same_samples(&dataset, &samples);
    assert_eq!(dataset.roles.far.as_deref(), Some("Tension out (N)"));
}

#[test]
fn a_table_without_header_is_numbered() {
    let samples = samples(60, 0.3);
    let text = table("", &samples, "\t", "\n");
    let flags = RequestedRoles {
        far: Some("col3".into()),
        effort: vec!["col2".into()],
        time: Some("col1".into()),
        ..plain()
    };
    let dataset = read(&text, &flags).unwrap();
    same_samples(&dataset, &samples);
    assert_eq!(dataset.logs[0].findings, ["there is no header: the columns are named col1 to col3"]);
}

#[test]
fn titles_above_the_header_are_skipped_and_told() {
    let samples = samples(60, 0.3);
    let header = "Bench 3\nDate, 2026-11-20\nt_s,tension_in_n,tension_out_n\n";
    let dataset = reads_as(&table(header, &samples, ",", "\n"), &samples);
    assert_eq!(dataset.logs[0].findings, ["skipped 2 lines above the header"]);
}

#[test]
fn a_last_line_that_was_cut_off_is_dropped_and_told() {
    let samples = samples(60, 0.3);
    let text = csv(&samples) + "0.6,7.1";
    let dataset = reads_as(&text, &samples);
    assert_eq!(dataset.logs[0].findings, ["line 62, the last, is cut off and was dropped"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_table_comes_back_to_the_bit_in_every_dialect(
        rows in prop::collection::vec((-1e6_f64..1e6, -1e-3_f64..1e-3), 25..60),
        delimiter in prop::sample::select(vec![",", ";", "\t", "|", " "]),
        decimal_comma: bool,
        end in prop::sample::select(vec!["\n", "\r\n"]),
        mark: bool,
    ) {
        let samples: Vec<Sample> =
            rows.iter().enumerate().map(|(i, &(near, far))| [i as f64 * 0.25, near, far]).collect();
        let header = ["t_s", "tension_in_n", "tension_out_n"].join(delimiter) + end;
        let mut text = table(&header, &samples, delimiter, end);
        if decimal_comma && delimiter != "," {
            text = text.replace('.', ",");
        }
        if mark {
            text.insert(0, '\u{feff}');
        }
        same_samples(&read(&text, &plain()).unwrap(), &samples);
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let _ = read_bytes(&[("any", &bytes)], &plain(), &options());
    }

    #[test]
    fn any_table_like_text_is_read_or_refused(
        text in "(t_s[,; \t]tension_in_n[,; \t]tension_out_n\r?\n)?([-+0-9.,;eEna# \t\"|%]{0,12}\r?\n){0,40}"
    ) {
        let _ = read(&text, &plain());
        let flags = RequestedRoles {
            far: Some("col1".into()),
            effort: vec!["col2".into()],
            group: Some("col3".into()),
            ..plain()
        };
        let _ = read(&text, &flags);
    }
}
