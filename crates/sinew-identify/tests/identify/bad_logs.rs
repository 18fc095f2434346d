//! Logs that cannot be used: one clear error each, which names the place, the value and what was expected.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{csv, message, options, read, read_all, samples};
use sinew_identify::Error;
use sinew_identify::log::{
    Input, ReadOptions, RequestedRoles, Role, Roles, read_bytes_with_roles, read_dataset,
};

fn plain() -> RequestedRoles {
    RequestedRoles::default()
}

/// The good log with line `number` (from 1, the header is line 1) replaced.
fn with_line(number: usize, line: &str) -> String {
    let text = csv(&samples(100, 0.0));
    let mut lines: Vec<&str> = text.lines().collect();
    lines[number - 1] = line;
    lines.join("\n") + "\n"
}

#[track_caller]
fn contains_all(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn the_good_log_is_good() {
    let dataset = read(&csv(&samples(100, 0.0)), &plain()).unwrap();
    assert_eq!(dataset.sequences.len(), 1);
    assert_eq!(dataset.logs[0].findings, Vec::<String>::new());
}

#[test]
fn a_misnamed_column_is_answered_with_the_nearest_name() {
    let flags = RequestedRoles { far: Some("Tension_Uot_n".into()), ..plain() };
    let got = message(&csv(&samples(100, 0.0)), &flags);
    contains_all(
        &got,
        &["log.csv", "`Tension_Uot_n`", "did you mean `tension_out_n`", "`t_s`, `tension_in_n`"],
    );
}

#[test]
fn a_missing_column_is_answered_with_the_list_of_columns() {
    let flags = RequestedRoles { effort: vec!["current_a".into()], ..plain() };
    let got = message(&csv(&samples(100, 0.0)), &flags);
    contains_all(&got, &["`current_a`", "columns are `t_s`, `tension_in_n`, `tension_out_n`"]);
    assert!(!got.contains("did you mean"), "{got}");
}

#[test]
fn no_far_column_asks_for_the_flag() {
    let text = csv(&samples(100, 0.0)).replace("tension_out_n", "y");
    contains_all(&message(&text, &plain()), &["far-end column", "`y`"]);
    let text = csv(&samples(100, 0.0)).replace("tension_in_n", "torque_out_nm");
    contains_all(
        &message(&text, &plain()),
        &["far-end column", "`tension_out_n`, `torque_out_nm` could each be it"],
    );
}

#[test]
fn no_inputs_lists_the_columns_and_the_flags() {
    let text = csv(&samples(100, 0.0)).replace("tension_in_n", "x");
    let flags = RequestedRoles { far: Some("tension_out_n".into()), ..plain() };
    contains_all(&message(&text, &flags), &["effort", "motion", "anchor", "given", "`t_s`, `x`"]);
}

#[test]
fn a_column_has_one_role() {
    let flags = RequestedRoles {
        effort: vec!["tension_in_n".into()],
        motion: vec!["tension_in_n".into()],
        ..plain()
    };
    contains_all(&message(&csv(&samples(100, 0.0)), &flags), &["`tension_in_n`", "effort", "motion"]);
    let flags = RequestedRoles { far: Some("t_s".into()), time: Some("t_s".into()), ..plain() };
    contains_all(&message(&csv(&samples(100, 0.0)), &flags), &["`t_s`", "far-end", "time"]);
}

#[test]
fn a_name_for_two_columns_is_refused_where_it_matters() {
    let text = csv(&samples(100, 0.0)).replace("t_s,tension_in_n", "tension_in_n,tension_in_n");
    contains_all(&message(&text, &plain()), &["two columns named `tension_in_n`"]);
}

#[test]
fn text_in_a_number_is_placed() {
    let got = message(&with_line(42, "0.4,6.x,5"), &plain());
    contains_all(&got, &["log.csv", "line 42", "`tension_in_n`", "`6.x`", "number"]);
}

#[test]
fn text_in_a_column_nobody_asked_for_is_no_business_of_ours() {
    let text = csv(&samples(100, 0.0));
    let mut lines = text.lines();
    let mut noted = format!("{},note\n", lines.next().unwrap());
    lines.for_each(|line| noted += &format!("{line},hello\n"));
    assert!(read(&noted, &plain()).is_ok());
}

#[test]
fn an_infinity_is_placed() {
    contains_all(
        &message(&with_line(10, "0.08,inf,5"), &plain()),
        &["line 10", "`tension_in_n`", "`inf`", "finite"],
    );
    contains_all(
        &message(&with_line(10, "0.08,6,-1e999"), &plain()),
        &["line 10", "`tension_out_n`", "-1e999"],
    );
}

#[test]
fn a_row_of_another_width_is_placed() {
    contains_all(&message(&with_line(10, "0.08,6"), &plain()), &["line 10", "3 fields", "found 2"]);
    contains_all(&message(&with_line(10, "0.08,6,5,4"), &plain()), &["line 10", "3 fields", "found 4"]);
}

#[test]
fn a_header_of_another_width_is_placed() {
    contains_all(
        &message(&with_line(1, "t_s,tension_in_n"), &plain()),
        &["line 1", "3 column names", "found 2"],
    );
}

#[test]
fn one_sample_is_too_few() {
    contains_all(&message(&csv(&samples(1, 0.0)), &plain()), &["at least 20 samples", "found 1"]);
    contains_all(&message(&csv(&samples(19, 0.0)), &plain()), &["at least 20 samples", "found 19"]);
}

#[test]
fn skipping_everything_is_too_few() {
    let logs = [("log.csv", csv(&samples(100, 0.0)))];
    let logs: Vec<(&str, &[u8])> = logs.iter().map(|(n, t)| (*n, t.as_bytes())).collect();
    let skip = ReadOptions { skip_s: 0.95, ..options() };
    let got = sinew_identify::log::read_bytes(&logs, &plain(), &skip).unwrap_err().to_string();
    contains_all(&got, &["scored", "at least 20", "found 5"]);
    let skip = ReadOptions { skip_s: f64::NAN, ..options() };
    assert!(sinew_identify::log::read_bytes(&logs, &plain(), &skip).is_err());
}

#[test]
fn a_header_alone_and_an_empty_file_hold_nothing() {
    contains_all(&message("t_s,tension_in_n,tension_out_n\n", &plain()), &["log.csv", "no number"]);
    contains_all(&message("", &plain()), &["log.csv", "no line of data"]);
    contains_all(&message("# nothing\n\n", &plain()), &["no line of data"]);
}

#[test]
fn all_nan_is_refused() {
    let mut nan = samples(100, 0.0);
    nan.iter_mut().for_each(|s| s[2] = f64::NAN);
    contains_all(&message(&csv(&nan), &plain()), &["`tension_out_n`", "no number"]);
    let mut nan = samples(100, 0.0);
    nan.iter_mut().for_each(|s| s[1] = f64::NAN);
    contains_all(&message(&csv(&nan), &plain()), &["`tension_in_n`", "no number"]);
}

#[test]
fn a_constant_far_side_is_refused() {
    let mut constant = samples(100, 0.0);
    constant.iter_mut().for_each(|s| s[2] = 2.5);
    contains_all(&message(&csv(&constant), &plain()), &["`tension_out_n`", "constant at 2.5"]);
}

#[test]
fn constant_inputs_are_refused_only_if_none_moves() {
    let mut constant = samples(100, 0.0);
    constant.iter_mut().for_each(|s| s[1] = 4.0);
    contains_all(&message(&csv(&constant), &plain()), &["`tension_in_n`", "constant at 4"]);
    let text = csv(&samples(100, 0.0));
    let mut lines = text.lines();
    let mut more = format!("{},stroke_mm\n", lines.next().unwrap());
    lines.for_each(|line| more += &format!("{line},7\n"));
    let dataset = read(&more, &plain()).unwrap();
    assert_eq!(dataset.roles.inputs.len(), 2);
    assert_eq!(dataset.logs[0].findings, ["`stroke_mm` is constant at 7 everywhere"]);
}

#[test]
fn time_that_runs_backwards_is_placed_with_both_values() {
    let got = message(&with_line(60, "0.4,6,5"), &plain());
    contains_all(&got, &["line 60", "0.57", "0.4", "backwards"]);
}

#[test]
fn stacked_trials_without_a_trial_column_ask_for_one() {
    let one = csv(&samples(100, 0.0));
    let (_, rows) =
        csv(&samples(100, 1.0)).split_once('\n').map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    contains_all(&message(&(one + &rows), &plain()), &["trial column", "line 102", "0.99", "0 s"]);
}

#[test]
fn logs_with_different_columns_are_named_both() {
    let good = csv(&samples(100, 0.0));
    let other = csv(&samples(100, 1.0)).replace("tension_in_n", "tension_motor_n");
    let got = read_all(&[("a.csv", &good), ("b.csv", &other)], &plain()).unwrap_err();
    assert!(matches!(got, Error::ColumnsDiffer { .. }), "{got}");
    contains_all(&got.to_string(), &["a.csv", "b.csv", "`tension_in_n`"]);
}

#[test]
fn a_group_must_exist_separate_and_hold_within_trials() {
    let group = |text: &str| message(text, &RequestedRoles { group: Some("load".into()), ..plain() });
    contains_all(&group(&csv(&samples(100, 0.0))), &["`load`"]);
    let table = |load: fn(usize) -> usize| {
        let mut text = String::from("t_s,tension_in_n,tension_out_n,load,trial\n");
        for (i, [t, near, far]) in samples(100, 0.0).iter().enumerate() {
            text += &format!("{t},{near},{far},{},{}\n", load(i), i / 50);
        }
        text
    };
    contains_all(&group(&table(|_| 3)), &["`load`", "same value `3`"]);
    contains_all(&group(&table(|i| i / 30)), &["`load`", "line 32", "`0` to `1`", "within a trial"]);
    assert!(read(&table(|i| i / 50), &RequestedRoles { group: Some("load".into()), ..plain() }).is_ok());
}

#[test]
fn two_time_columns_are_the_users_choice() {
    let text = csv(&samples(100, 0.0)).replace("t_s,tension_in_n", "t_s,time_s");
    let flags = RequestedRoles { far: Some("tension_out_n".into()), ..plain() };
    contains_all(&message(&text, &flags), &["time column", "`t_s`, `time_s`"]);
}

#[test]
fn files_that_are_no_table_are_refused_by_kind() {
    let of = |bytes: &[u8]| {
        sinew_identify::log::read_bytes(&[("x.csv", bytes)], &plain(), &options()).unwrap_err().to_string()
    };
    contains_all(&of(&[0xFF, 0xFE, b'a', 0]), &["x.csv", "UTF-16", "UTF-8"]);
    contains_all(&of(&[1, 2, 0, 3]), &["binary"]);
    let mut endless = b"t_s,tension_in_n,tension_out_n\n0,1,2\n".to_vec();
    endless.extend(std::iter::repeat_n(b'1', 3 << 20));
    contains_all(&of(&endless), &["line 3", "without a line end"]);
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let options = ReadOptions { paths: vec!["no/such/file.csv".into()], ..options() };
    contains_all(&read_dataset(&plain(), &options).unwrap_err().to_string(), &["file.csv", "cannot be read"]);
    let none = ReadOptions { paths: Vec::new(), ..options };
    assert!(matches!(read_dataset(&plain(), &none), Err(Error::NoLogs)));
}

#[test]
fn a_log_that_does_not_fit_a_model_is_refused() {
    let roles = Roles {
        far: Some("tension_out_n".into()),
        inputs: vec![Input { column: "stroke_mm".into(), role: Role::Motion }],
        time: Some("t_s".into()),
        trial: None,
        group: None,
        units: std::collections::BTreeMap::new(),
    };
    let text = csv(&samples(100, 0.0));
    let got = read_bytes_with_roles(&[("log.csv", text.as_bytes())], &roles, &options()).unwrap_err();
    contains_all(&got.to_string(), &["log.csv", "`stroke_mm`", "`tension_in_n`"]);
}
