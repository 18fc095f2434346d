//! Logs that cannot be used: one error that names the place, the exit code of bad input, nothing written.

use crate::bench::{BAD_INPUT, Bench, ended, log, with_line};

const IDENTIFY: &str = "identify bad.csv --model cell --out out";

/// `identify` refuses this log and writes no file.
#[track_caller]
fn refuses(content: impl AsRef<[u8]>, parts: &[&str]) {
    let bench = Bench::new();
    bench.write("bad.csv", content);
    bench.refuses(IDENTIFY, &[&["bad.csv"], parts].concat());
}

#[test]
fn a_misnamed_column_is_answered_with_the_nearest() {
    let bench = Bench::new();
    bench.refuses(
        "identify a.csv --far tension_uot_n --out out",
        &["a.csv", "`tension_uot_n`", "did you mean `tension_out_n`?"],
    );
}

#[test]
fn a_missing_column_is_answered_with_those_that_are_there() {
    let bench = Bench::new();
    bench.refuses(
        "identify a.csv --effort current_a --out out",
        &["a.csv", "`current_a`", "`tension_in_n`, `tension_out_n`"],
    );
    refuses(log(0.4).replace("tension_out_n", "y"), &["--far", "`y`"]);
}

#[test]
fn text_in_a_number_is_answered_with_line_and_column() {
    refuses(with_line(17, "0.3,offline,50.0"), &["line 17", "`tension_in_n`", "offline"]);
}

#[test]
fn a_row_that_is_too_short_is_answered_with_its_line() {
    refuses(with_line(33, "0.62,55.0"), &["line 33"]);
}

#[test]
fn one_sample_is_too_few() {
    refuses("time_s,tension_in_n,tension_out_n\n0.0,50.0,40.0\n", &["expected at least", "found 1"]);
}

#[test]
fn a_constant_far_end_cannot_be_identified() {
    let constant = |line: &str| line.rsplit_once(',').unwrap().0.to_owned() + ",42.0\n";
    let mut text: String = log(0.4).lines().skip(1).map(constant).collect();
    text.insert_str(0, "time_s,tension_in_n,tension_out_n\n");
    refuses(text, &["`tension_out_n`", "constant at 42"]);
}

#[test]
fn a_constant_near_side_cannot_identify() {
    let constant = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        format!("{},7.5,{}\n", cells[0], cells[2])
    };
    let mut text: String = log(0.4).lines().skip(1).map(constant).collect();
    text.insert_str(0, "time_s,tension_in_n,tension_out_n\n");
    refuses(text, &["`tension_in_n`", "constant at 7.5"]);
}

#[test]
fn a_column_without_any_number_is_named() {
    let nan = |line: &str| line.rsplit_once(',').unwrap().0.to_owned() + ",NaN\n";
    let mut text: String = log(0.4).lines().skip(1).map(nan).collect();
    text.insert_str(0, "time_s,tension_in_n,tension_out_n\n");
    refuses(text, &["`tension_out_n`", "no number"]);
}

#[test]
fn time_that_runs_backwards_is_answered_with_its_line() {
    refuses(with_line(60, "1.10,60.0,50.0"), &["line 60", "backwards", "1.1"]);
}

#[test]
fn logs_with_different_columns_are_refused_with_both_names() {
    let bench = Bench::new();
    bench.write("bad.csv", log(0.4).replace("tension_in_n", "torque_in_nm"));
    bench.refuses("identify a.csv bad.csv --model cell --out out", &["bad.csv", "a.csv", "`tension_in_n`"]);
    bench.refuses("identify bad.csv a.csv --model cell --out out", &["bad.csv", "a.csv"]);
}

#[test]
fn files_that_are_no_logs_are_refused() {
    refuses("", &["no line of data"]);
    refuses("\n\n\n", &[]);
    refuses("time_s,tension_in_n,tension_out_n\n", &[]);
    refuses(b"time_s,tension_in_n\n0.0,\xff\xfe\n0.1,\xff\n".as_slice(), &[]);
    refuses([0_u8, 1, 2, 3, 255, 254, 0, 0, 17].repeat(400), &[]);
    refuses(vec![0_u8; 4096], &[]);
    refuses("{\"time_s\": [0, 1], \"tension_in_n\": [1, 2]}\n", &[]);
    refuses(b"\x93NUMPY\x01\0v\0{'descr': '<f8'}\n".as_slice(), &[]);
}

#[test]
fn a_log_that_is_not_there_is_named() {
    let bench = Bench::new();
    bench.refuses("identify missing.csv --out out", &["missing.csv"]);
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench.refuses("identify folder --out out", &["folder"]);
}

#[test]
fn a_format_that_needs_a_feature_or_another_program_is_named() {
    let bench = Bench::new();
    bench.write("log.xlsx", b"PK\x03\x04rest of a spreadsheet");
    bench.refuses("identify log.xlsx --out out", &["log.xlsx"]);
}

#[test]
fn options_outside_their_domain_are_named() {
    let bench = Bench::new();
    bench.refuses_usage("identify a.csv --out out --skip NaN", &["--skip", "NaN", ">= 0"]);
    bench.refuses_usage("identify a.csv --out out --skip=-1", &["--skip", "-1", ">= 0"]);
    bench.refuses("identify a.csv --out out --skip 1e9", &["a.csv", "skipped"]);
    bench.refuses("identify a.csv --out out --model cel", &["--model", "cel", "cell"]);
    bench.refuses("identify a.csv --out out --group load", &["`load`"]);
}

#[test]
fn control_characters_in_a_name_are_escaped() {
    let text = log(0.4).replace("tension_out_n", "\"a\nb\x1b[31m\"");
    refuses(text, &[]);
    let bench = Bench::new();
    bench.write("bad.csv", log(0.4).replace("tension_out_n", "y\x1b[31mred"));
    let outcome = bench.run(IDENTIFY);
    assert_eq!(outcome.code, Some(2));
    assert!(!outcome.stderr.contains('\x1b'), "{:?}", outcome.stderr);
}

#[cfg(unix)]
#[test]
fn a_file_that_does_not_fit_memory_is_refused_with_its_size() {
    let bench = Bench::new();
    // A sparse file of 3 GB.
    let mut head = vec![b' '; 124];
    head[..19].copy_from_slice(b"MATLAB 5.0 MAT-file");
    head.extend(b"\x00\x01IM");
    bench.write("big.mat", head);
    let file = std::fs::OpenOptions::new().write(true).open(bench.path("big.mat")).unwrap();
    file.set_len(3 << 30).unwrap();
    let outcome = bench.run("identify big.mat --out out");
    ended(BAD_INPUT, "3 GB", &outcome, &["big.mat", "too large", "3072 MB"]);
    assert!(!bench.path("out").exists());
}
