//! From tables to sequences: trials, gaps, repeated rows, spikes, conditions, duplicates.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{Sample, csv, options, read, read_all, samples};
use sinew_identify::log::{
    Dataset, Input, ReadOptions, RequestedRoles, Role, Roles, read_bytes, read_bytes_with_roles, read_dataset,
};

fn plain() -> RequestedRoles {
    RequestedRoles::default()
}

fn findings(dataset: &Dataset) -> String {
    dataset.logs.iter().flat_map(|log| log.findings.clone()).collect::<Vec<_>>().join("\n")
}

/// The samples as a table with further columns, one value of each per sample.
fn with_columns(names: &str, samples: &[Sample], more: impl Fn(usize) -> String) -> String {
    let mut text = format!("t_s,tension_in_n,tension_out_n,{names}\n");
    for (i, [t, near, far]) in samples.iter().enumerate() {
        text += &format!("{t},{near},{far},{}\n", more(i));
    }
    text
}

#[test]
fn a_gap_cuts_and_is_told() {
    let mut logged = samples(400, 0.0);
    logged[200..].iter_mut().for_each(|s| s[0] += 1.5);
    let dataset = read(&csv(&logged), &plain()).unwrap();
    let lengths: Vec<usize> = dataset.sequences.iter().map(|s| s.row.len()).collect();
    assert_eq!(lengths, [200, 200]);
    assert_eq!(dataset.logs[0].trials, 1);
    assert!(findings(&dataset).contains("1 gap, states reset after it: 1.51 s after 1.99 s (line 202)"));
    assert!((dataset.logs[0].duration_s - 3.98).abs() < 1e-9);
}

#[test]
fn a_slow_irregular_log_is_not_cut_but_told() {
    let mut logged = samples(300, 0.0);
    let mut t = 0.0;
    for (i, sample) in logged.iter_mut().enumerate() {
        t += if i % 7 == 0 { 1.1 } else { 0.4 + 0.05 * (i % 5) as f64 };
        sample[0] = t;
    }
    let dataset = read(&csv(&logged), &plain()).unwrap();
    assert_eq!(dataset.sequences.len(), 1);
    assert!(findings(&dataset).contains("sampling is irregular: 500.000 ms in the median"));
}

#[test]
fn repeated_rows_are_dropped_and_told() {
    let mut logged = samples(100, 0.0);
    logged.insert(50, logged[49]);
    logged.insert(51, logged[49]);
    let dataset = read(&csv(&logged), &plain()).unwrap();
    assert_eq!(dataset.logs[0].samples, 100);
    assert!(findings(&dataset).contains("2 repeated rows, dropped: line 52, line 53"));
}

#[test]
fn of_two_rows_at_one_time_the_first_is_kept_and_that_is_told() {
    let mut logged = samples(100, 0.0);
    logged[50][0] = logged[49][0];
    let dataset = read(&csv(&logged), &plain()).unwrap();
    assert_eq!(dataset.logs[0].samples, 99);
    assert_eq!(dataset.sequences[0].inputs[49].to_bits(), logged[49][1].to_bits());
    assert!(findings(&dataset).contains("1 duplicate timestamp with other values, first kept"));
    assert!(dataset.sequences[0].time_s.windows(2).all(|w| w[0] < w[1]));
}

#[test]
fn stamps_with_too_few_digits_are_refused_with_the_rate() {
    let mut logged = samples(400, 0.0);
    logged.iter_mut().for_each(|sample| sample[0] = (sample[0] * 10.0 + 1e-9).floor() / 10.0);
    let error = read(&csv(&logged), &plain()).unwrap_err().to_string();
    assert!(error.contains("360 of 400 samples") && error.contains("--rate 100"), "{error}");
}

#[test]
fn missing_cells_are_nan_counted_and_not_scored_on_the_far_side() {
    let text = csv(&samples(100, 0.0));
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[10] = "0.09,NaN,5".into();
    lines[20] = "0.19,6,".into();
    lines[30] = "0.29,6,NA".into();
    lines[40] = "null,6,5".into();
    let dataset = read(&lines.join("\n"), &plain()).unwrap();
    let sequence = &dataset.sequences[0];
    assert_eq!(sequence.row.len(), 99);
    assert!(sequence.inputs[9].is_nan() && sequence.scored[9]);
    assert!(sequence.far[19].is_nan() && !sequence.scored[19]);
    let findings = findings(&dataset);
    assert!(findings.contains("1 cell without a number in `tension_in_n`: line 11"), "{findings}");
    assert!(findings.contains("2 cells without a number in `tension_out_n`: line 21, line 31"), "{findings}");
    assert!(findings.contains("1 row without a timestamp, dropped: line 41"), "{findings}");
}

#[test]
fn far_side_spikes_are_told_and_neither_fitted_nor_scored() {
    let mut logged = samples(400, 0.0);
    logged[100][2] += 50.0;
    logged[250][2] -= 80.0;
    let clean = samples(400, 0.0);
    let dataset = read(&csv(&logged), &plain()).unwrap();
    let sequence = &dataset.sequences[0];
    let unscored: Vec<usize> = (0..400).filter(|&i| !sequence.scored[i]).collect();
    assert_eq!(unscored, [100, 250]);
    assert!((sequence.far[100] - logged[100][2]).abs() < 1e-12, "the log stays as it is");
    for (far_clean, clean) in sequence.far_clean.iter().zip(&clean) {
        assert!((far_clean - clean[2]).abs() < 0.2);
    }
    let findings = findings(&dataset);
    assert!(findings.contains("2 spikes of `tension_out_n`") && findings.contains("line 102"), "{findings}");
}

#[test]
fn without_spikes_the_far_side_is_fitted_as_it_is() {
    let dataset = read(&csv(&samples(400, 0.0)), &plain()).unwrap();
    assert_eq!(dataset.sequences[0].far, dataset.sequences[0].far_clean);
}

#[test]
fn near_side_spikes_are_told_and_left() {
    let mut logged = samples(400, 0.0);
    logged[100][1] += 50.0;
    let dataset = read(&csv(&logged), &plain()).unwrap();
    assert!((dataset.sequences[0].inputs[100] - logged[100][1]).abs() < 1e-12);
    assert!(dataset.sequences[0].scored.iter().all(|s| *s));
    assert!(findings(&dataset).contains("1 spike of `tension_in_n`, left in"));
}

#[test]
fn trials_are_separate_and_their_labels_may_be_words() {
    let mut logged = samples(60, 0.0);
    logged.extend(samples(60, 1.0));
    logged.extend(samples(60, 2.0));
    let names = ["slow", "fast 1", "fast 2"];
    for column in ["trial", "episode", "Trial_ID"] {
        let dataset = read(&with_columns(column, &logged, |i| names[i / 60].into()), &plain()).unwrap();
        assert_eq!(dataset.roles.trial.as_deref(), Some(column));
        let labels: Vec<&str> = dataset.sequences.iter().map(|s| s.trial.as_str()).collect();
        assert_eq!(labels, names);
        assert_eq!(dataset.logs[0].trials, 3);
        assert!(dataset.conditions.is_empty(), "a trial column is no condition");
    }
}

#[test]
fn skipped_seconds_count_from_the_start_of_the_trial_and_not_after_a_gap() {
    let mut logged = samples(200, 0.0);
    logged.iter_mut().for_each(|s| s[0] += 7.0);
    logged[100..].iter_mut().for_each(|s| s[0] += 3.0);
    let mut second = samples(200, 1.0);
    second.iter_mut().for_each(|s| s[0] += 100.0);
    logged.extend(second);
    let text = with_columns("trial", &logged, |i| (i / 200).to_string());
    let skip = ReadOptions { skip_s: 0.5, ..options() };
    let dataset = read_bytes(&[("log.csv", text.as_bytes())], &plain(), &skip).unwrap();
    let unscored: Vec<usize> =
        dataset.sequences.iter().map(|s| s.scored.iter().filter(|k| !**k).count()).collect();
    assert_eq!(unscored, [50, 0, 50]);
    assert!(findings(&dataset).contains("100 samples in the first 0.5 s"));
}

#[test]
fn conditions_are_what_is_constant_within_trials_and_varies_between_them() {
    let mut logged = Vec::new();
    for k in 0..12 {
        logged.extend(samples(30, f64::from(k)));
    }
    let text = with_columns("trial,freq_hz,load_pct,two,serial,moving", &logged, |i| {
        let k = i / 30;
        format!("{k},{}.10,{},{},{},{i}", k % 3, 10 * (k / 3), k % 2, 100 + k)
    });
    let dataset = read(&text, &plain()).unwrap();
    let found: Vec<(&str, usize)> =
        dataset.conditions.iter().map(|c| (c.column.as_str(), c.values.len())).collect();
    assert_eq!(found, [("freq_hz", 3), ("load_pct", 4), ("serial", 12)]);
    assert_eq!(dataset.conditions[0].values, ["0.1", "1.1", "2.1"]);
    assert_eq!(dataset.sequences[4].condition_values, ["1.1", "10", "104"]);
    let group = RequestedRoles { group: Some("trial".into()), ..plain() };
    assert_eq!(read(&text, &group).unwrap().conditions[0].values.len(), 12, "one fold per trial");
    let group = RequestedRoles { group: Some("two".into()), ..plain() };
    let dataset = read(&text, &group).unwrap();
    assert_eq!(dataset.conditions[0].column, "two", "the group comes first, even with two values");
    assert_eq!(dataset.sequences[3].condition_values[0], "1");
}

#[test]
fn a_column_that_is_constant_in_every_log_is_a_condition() {
    let texts: Vec<String> = (0..5)
        .map(|k| with_columns("sheath_deg", &samples(50, f64::from(k)), |_| (60 * k).to_string()))
        .collect();
    let names: Vec<String> = (0..5).map(|k| format!("bend_{k}.csv")).collect();
    let logs: Vec<(&str, &str)> = names.iter().zip(&texts).map(|(n, t)| (n.as_str(), t.as_str())).collect();
    let dataset = read_all(&logs, &plain()).unwrap();
    assert_eq!(dataset.conditions.len(), 1);
    assert_eq!(dataset.conditions[0].values, ["0", "60", "120", "180", "240"]);
    assert_eq!(dataset.roles.inputs[1], Input { column: "sheath_deg".into(), role: Role::Given });
    let findings = findings(&dataset);
    assert!(!findings.contains("sheath_deg"), "a given quantity may be constant within a log: {findings}");
}

#[test]
fn without_trials_a_group_cuts_where_it_changes() {
    let text = with_columns("load", &samples(90, 0.0), |i| ["a", "b", "a"][i / 30].into());
    let dataset = read(&text, &RequestedRoles { group: Some("load".into()), ..plain() }).unwrap();
    let values: Vec<&str> = dataset.sequences.iter().map(|s| s.condition_values[0].as_str()).collect();
    assert_eq!(values, ["a", "b", "a"]);
}

#[test]
fn a_duplicated_log_counts_once_and_its_twin_says_so() {
    let (a, b) = (csv(&samples(100, 0.0)), csv(&samples(100, 1.0)));
    let copy = a.replace(',', ";");
    let dataset = read_all(&[("z.csv", &copy), ("a.csv", &a), ("b.csv", &b)], &plain()).unwrap();
    let names: Vec<&str> = dataset.logs.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["a.csv", "b.csv"]);
    assert_eq!(dataset.logs[0].findings, ["z.csv holds the same samples and was left out"]);
    assert_eq!(dataset.sequences.iter().map(|s| s.log).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn a_log_that_shares_a_trial_with_another_loses_that_trial() {
    let first = with_columns("trial", &samples(60, 0.0), |_| "1".into());
    let mut logged = samples(60, 0.0);
    logged.extend(samples(60, 2.0));
    let second = with_columns("trial", &logged, |i| (i / 60).to_string());
    let dataset = read_all(&[("a.csv", &first), ("b.csv", &second)], &plain()).unwrap();
    assert_eq!(dataset.sequences.len(), 2);
    assert_eq!(dataset.logs[1].samples, 60);
    assert_eq!(dataset.logs[1].findings, ["dropped 1 sequence that a.csv holds too"]);
}

#[test]
fn shuffling_logs_or_columns_changes_nothing() {
    let logged = samples(100, 0.0);
    let a = with_columns("stroke_mm,x", &logged, |i| format!("{},{}", (i as f64 * 0.1).sin(), i));
    let mut b = String::from("x,stroke_mm,tension_out_n,t_s,tension_in_n\n");
    for (i, [t, near, far]) in samples(100, 0.5).iter().enumerate() {
        b += &format!("{i},{},{far},{t},{near}\n", (i as f64 * 0.2).sin());
    }
    let one = read_all(&[("a.csv", &a), ("b.csv", &b)], &plain()).unwrap();
    let two = read_all(&[("b.csv", &b), ("a.csv", &a)], &plain()).unwrap();
    assert_eq!(format!("{one:?}"), format!("{two:?}"));
    // The columns of `a` in another order.
    let shuffled: String = a
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [4, 2, 0, 3, 1].map(|k| cells[k]).join(",") + "\n"
        })
        .collect();
    let three = read_all(&[("a.csv", &shuffled), ("b.csv", &b)], &plain()).unwrap();
    assert_eq!(format!("{one:?}"), format!("{three:?}"));
}

#[test]
fn files_are_read_as_bytes_are_and_named_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for (k, name) in ["day1", "day2"].iter().enumerate() {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        let path = folder.path().join(name).join("run.csv");
        std::fs::write(&path, csv(&samples(3000, k as f64))).unwrap();
        paths.push(path);
    }
    let files = read_dataset(&plain(), &ReadOptions { paths, ..options() }).unwrap();
    let (a, b) = (csv(&samples(3000, 0.0)), csv(&samples(3000, 1.0)));
    let bytes = read_all(&[("day1/run.csv", &a), ("day2/run.csv", &b)], &plain()).unwrap();
    assert_eq!(files.logs[0].name, "day1/run.csv");
    assert_eq!(format!("{files:?}"), format!("{bytes:?}"));
}

#[test]
fn a_model_needs_no_far_side_to_predict_and_trials_are_found_by_name() {
    let roles = Roles {
        far: Some("tension_out_n".into()),
        inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
        time: Some("t_s".into()),
        trial: None,
        group: Some("load".into()),
        units: std::collections::BTreeMap::new(),
    };
    let mut text = String::from("trial,t_s,tension_in_n\n");
    for (i, [t, near, _]) in samples(30, 0.0).iter().enumerate() {
        text += &format!("{},{t},{near}\n", i / 15);
    }
    let predict = ReadOptions { far_required: false, ..options() };
    let dataset = read_bytes_with_roles(&[("log.csv", text.as_bytes())], &roles, &predict).unwrap();
    assert_eq!(dataset.roles.far, None);
    assert_eq!(dataset.sequences.len(), 2);
    assert!(dataset.sequences.iter().all(|s| s.far.iter().all(|x| x.is_nan())));
    let twice = [("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())];
    let dataset_of_two = read_bytes_with_roles(&twice, &roles, &predict).unwrap();
    assert_eq!(dataset_of_two.sequences.len(), 4, "every row asked for is predicted");
    let evaluate = read_bytes_with_roles(&[("log.csv", text.as_bytes())], &roles, &options());
    assert!(evaluate.unwrap_err().to_string().contains("`tension_out_n`"));
}
