//! Logs that are read and wrong: what is wrong is named with line, channel and consequence; time in every
//! usual form; names and units that differ from day to day.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::benches::{Bench, Kind, Table};
use common::{csv, options, read, read_all, samples};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_identify::Error;
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{
    ColumnOptions, Dataset, DefectKind, Input, ReadOptions, RequestedRoles, Role, Roles, read_bytes,
    read_bytes_with_roles,
};
use sinew_identify::report::Grade;

fn plain() -> RequestedRoles {
    RequestedRoles::default()
}

/// Two columns called as on many benches.
fn cells() -> RequestedRoles {
    RequestedRoles { far: Some("LC_dist".into()), effort: vec!["LC_prox".into()], ..plain() }
}

fn read_with(
    logs: &[(&str, &str)],
    flags: &RequestedRoles,
    columns: ColumnOptions,
) -> Result<Dataset, Error> {
    let logs: Vec<(&str, &[u8])> = logs.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
    read_bytes(&logs, flags, &ReadOptions { columns, ..options() })
}

/// A log of the samples whose time is written by `time` under a name.
fn timed(name: &str, time: impl Fn(f64) -> String) -> String {
    let mut text = format!("{name};tension_in_n;tension_out_n\n");
    for [t, near, far] in samples(100, 0.0) {
        text += &format!("{};{near};{far}\n", time(t));
    }
    text
}

fn two_days(bench: &Bench, count: usize, seed: u64) -> Vec<Table> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| bench.log(&mut random)).collect()
}

fn identified(tables: &[Table]) -> Identification {
    let texts: Vec<(String, String)> =
        tables.iter().enumerate().map(|(k, table)| (format!("day{k}.csv"), table.csv())).collect();
    let logs: Vec<(&str, &[u8])> =
        texts.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let data = read_bytes(&logs, &plain(), &options()).unwrap();
    let options = Options { seed: 1, models: vec!["cell".to_owned()], ..Options::default() };
    identify(&data, &options, &|_, _| {}).unwrap()
}

fn bench() -> Bench {
    Bench::sampled(Kind::Sheath, &mut ChaCha8Rng::seed_from_u64(31))
}

#[test]
fn a_near_cell_that_saturates_in_every_log_is_named_and_lowers_the_grade() {
    let mut tables = two_days(&bench(), 3, 1);
    let good = identified(&tables);
    assert!(good.report.logs.iter().all(|log| log.defects.is_empty()));
    for table in &mut tables {
        let mut sorted = table.column("tension_in_n").clone();
        sorted.sort_by(f64::total_cmp);
        let bound = sorted[sorted.len() * 4 / 10];
        table.column("tension_in_n").iter_mut().for_each(|x| *x = x.min(bound));
    }
    let found = identified(&tables).report;
    assert_ne!(found.grade, Grade::Use);
    for log in &found.logs {
        let defect = &log.defects[0];
        assert_eq!((defect.kind, defect.column.as_str()), (DefectKind::Clipped, "tension_in_n"));
        assert!(defect.line.is_some_and(|line| line > 1) && log.findings.contains(&defect.sentence));
    }
    assert!(
        found.recommendations[0].contains("`tension_in_n` of day0.csv is clipped"),
        "{:?}",
        found.recommendations
    );
}

#[test]
fn the_odd_one_of_three_is_left_out_with_its_channel_and_two_are_undecidable() {
    let mut tables = two_days(&bench(), 3, 2);
    tables[1].column("tension_out_n").iter_mut().for_each(|x| *x *= 0.224_809);
    let found = identified(&tables).report;
    let row = found.influence.iter().find(|row| row.dropped).unwrap();
    assert_eq!(row.log, "day1.csv");
    assert!(row.remark.contains("`tension_out_n` reads 0.2") && row.remark.contains("lbf"), "{}", row.remark);
    assert_ne!(found.grade, Grade::Use);
    let found = identified(&tables[..2]).report;
    assert_ne!(found.grade, Grade::Use);
    for log in &found.logs {
        let said = &log.defects[0];
        assert_eq!(said.kind, DefectKind::Contradiction);
        assert!(said.sentence.contains("a third log decides"), "{}", said.sentence);
    }
}

#[test]
fn time_is_read_in_every_usual_form_to_the_same_samples() {
    let expected = read(&csv(&samples(100, 0.0)), &plain()).unwrap();
    let forms: Vec<String> = vec![
        timed("Zeit [ms]", |t| format!("{}", 1e3 * t)),
        timed("tid", |t| t.to_string()),
        timed("elapsed_us", |t| format!("{}", 1e6 * t)),
        timed("timestamp", |t| format!("2026-03-01T12:00:00.{:03}Z", (1e3 * t).round())),
        timed("Unnamed: 0", |t| format!("2026-03-01 12:00:00.{:03}", (1e3 * t).round())),
        timed("Time", |t| format!("{t} sec")),
        timed("time_ms", |t| format!("0 days 00:00:00.{:03}", (1e3 * t).round())),
        timed("t_s", |t| format!("{t} s")),
        timed("unix", |t| format!("2026-03-01 12:00:00.{:03}+01:00", (1e3 * t).round())),
        timed("time", |t| format!("{}", 1.772e12 + (1e3 * t).round())),
        timed("seconds", |t| t.to_string()),
        timed("Uhrzeit", |t| format!("12:00:00,{:03}", (1e3 * t).round())),
        timed("clock", |t| format!("0:{t:06.3}")),
    ];
    for text in forms {
        let head = text.lines().take(2).collect::<Vec<_>>().join(" / ");
        let found = read(&text, &plain()).unwrap_or_else(|e| panic!("{head}: {e}"));
        let first = found.sequences[0].time_s[0];
        for (a, b) in found.sequences[0].time_s.iter().zip(&expected.sequences[0].time_s) {
            assert!((a - first - b).abs() < 1e-6, "{head}: {a} {b}");
        }
        assert_eq!(found.sequences[0].far, expected.sequences[0].far, "{head}");
    }
    let rows = timed("X_Value", |t| t.to_string()).replacen('\n', "\n[s];[N];[N]\n", 1);
    assert_eq!(read(&rows, &plain()).unwrap().sequences[0].time_s, expected.sequences[0].time_s);
    let rows = timed("whatever", |t| (1e3 * t).to_string()).replacen('\n', "\n[ms];[N];[N]\n", 1);
    assert_eq!(read(&rows, &plain()).unwrap().roles.time.as_deref(), Some("whatever"));
}

#[test]
fn without_a_time_column_the_remedy_is_named_and_a_rate_is_one() {
    let text = csv(&samples(100, 0.0)).replace("t_s", "n");
    let refused = read(&text, &plain()).unwrap_err();
    assert!(matches!(refused, Error::NoTime { .. }));
    for part in ["log.csv", "--time COL", "--rate HZ", "rate_hz=", "`n`"] {
        assert!(refused.to_string().contains(part), "{refused}");
    }
    let rate = |rate_hz| ColumnOptions { rate_hz: Some(rate_hz), ..ColumnOptions::default() };
    let found = read_with(&[("log.csv", &text)], &plain(), rate(100.0)).unwrap();
    assert_eq!(found.roles.time, None);
    assert!(
        (found.sequences[0].time_s[99] - 0.99).abs() < 1e-9
            && (found.logs[0].interval_s - 0.01).abs() < 1e-12
    );
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(read_with(&[("log.csv", &text)], &plain(), rate(wrong)).is_err());
    }
    let roles = Roles {
        far: Some("tension_out_n".into()),
        inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
        time: Some("t_s".into()),
        trial: None,
        group: None,
        units: std::collections::BTreeMap::new(),
    };
    let bytes = [("log.csv", text.as_bytes())];
    assert!(read_bytes_with_roles(&bytes, &roles, &options()).is_err());
    let counted = ReadOptions { columns: rate(100.0), ..options() };
    assert_eq!(read_bytes_with_roles(&bytes, &roles, &counted).unwrap().sequences[0].time_s.len(), 100);
    let without = Roles { time: None, ..roles };
    assert!(matches!(read_bytes_with_roles(&bytes, &without, &options()), Err(Error::NoTime { .. })));
}

#[test]
fn a_unit_of_time_that_is_unusual_is_asked_for_or_named() {
    let ms = |name: &str| timed(name, |t| (1e3 * t).to_string());
    let asked = read(&ms("time"), &plain()).unwrap_err().to_string();
    for part in ["`time`", "10 from sample to sample", "--units time=ms"] {
        assert!(asked.contains(part), "{asked}");
    }
    let units =
        |unit: &str| ColumnOptions { units: vec![("time".into(), unit.into())], ..ColumnOptions::default() };
    let text = ms("time");
    let found = read_with(&[("log.csv", &text)], &plain(), units("ms")).unwrap();
    assert!((found.logs[0].interval_s - 0.01).abs() < 1e-12);
    let refused = read_with(&[("log.csv", &text)], &plain(), units("mm")).unwrap_err().to_string();
    assert!(refused.contains("expected a unit") && refused.contains("ms"), "{refused}");
    let named = read(&ms("time_s"), &plain()).unwrap();
    assert_eq!(named.logs[0].defects[0].kind, DefectKind::Clock);
}

#[test]
fn names_with_and_without_units_are_one_column_and_numbers_are_converted() {
    let text = csv(&samples(100, 0.0));
    let bare = text.replace("tension_in_n", "LC_prox").replace("tension_out_n", "LC_dist");
    let bracketed = text.replace("tension_in_n", "LC_prox [N]").replace("tension_out_n", "LC_dist [N]");
    let expected = read(&bare, &cells()).unwrap();
    let found = read(&bracketed, &cells()).unwrap();
    assert_eq!(format!("{:?}", found.sequences), format!("{:?}", expected.sequences));
    assert_eq!(found.roles, expected.roles);
    assert_eq!(found.unit("LC_prox"), "N");
    // One day with units and one without, in newtons and kilonewtons.
    let mut kilo = String::from("t_s,LC_prox [kN],LC_dist [N]\n");
    for [t, near, far] in samples(100, 1.0) {
        kilo += &format!("{t},{},{far}\n", near / 1e3);
    }
    let both = read_all(&[("a.csv", &bracketed), ("b.csv", &kilo)], &cells()).unwrap();
    let near = samples(100, 1.0)[40][1];
    assert!((both.sequences[1].inputs[40] - near).abs() < 1e-9);
    assert!(both.logs[1].findings[0].contains("multiplied by 1000"), "{:?}", both.logs[1].findings);
}

#[test]
fn laws_are_the_same_with_and_without_units() {
    let table = &two_days(&Bench::sampled(Kind::Tension, &mut ChaCha8Rng::seed_from_u64(5)), 1, 3)[0];
    let text = table.csv();
    let laws = |near: &str, far: &str| {
        let text = text.replace("tension_in_n", near).replace("tension_out_n", far);
        let flags = RequestedRoles { far: Some(far.into()), effort: vec![near.into()], ..plain() };
        let data = read(&text, &flags).unwrap();
        let found = sinew_identify::fit::classical::fit_classical(&data);
        found.into_iter().map(|law| law.law).collect::<Vec<_>>()
    };
    assert_eq!(laws("LC_prox", "LC_dist"), laws("LC_prox [N]", "LC_dist [N]"));
}

#[test]
fn columns_are_mapped_across_days() {
    let a = csv(&samples(100, 0.0));
    let b = csv(&samples(100, 1.0)).replace("tension_in_n", "F1").replace("t_s", "time_s");
    assert!(read_all(&[("a.csv", &a), ("b.csv", &b)], &plain()).is_err());
    let rename = |old: &str| ColumnOptions {
        rename: vec![(old.into(), "tension_in_n".into())],
        ..ColumnOptions::default()
    };
    let found = read_with(&[("a.csv", &a), ("b.csv", &b)], &plain(), rename("F1")).unwrap();
    assert_eq!(found.sequences.len(), 2);
    let refused = read_with(&[("a.csv", &a), ("b.csv", &b)], &plain(), rename("F2")).unwrap_err();
    assert!(matches!(refused, Error::MissingColumn { .. }), "{refused}");
}
