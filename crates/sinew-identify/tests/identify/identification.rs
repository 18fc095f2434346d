//! From simulated logs to a model: known parameters are recovered, outlier logs are found, wrong structures
//! are reported.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{Sample, csv, read_all};
use sinew_identify::adapt::adapt;
use sinew_identify::evaluate::{conditions_of, evaluate, roles_of};
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{
    ColumnOptions, Dataset, ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles,
};

/// A cable with play between `low` and `high` times the near tension, seen by a noisy far sensor.
fn cable(n: usize, phase: f64, [low, high]: [f64; 2], noise: f64) -> Vec<Sample> {
    let (mut far, mut state) = (5.0_f64, 1_u32 + (phase * 1e3) as u32);
    (0..n)
        .map(|i| {
            let t = i as f64 * 0.01;
            let near = 6.0 + 3.0 * (2.0 * t + phase).sin() + 0.8 * (5.3 * t + phase).cos();
            far = far.clamp(low * near, high * near);
            // A small linear congruential generator is noise enough here.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [t, near, far + noise * (f64::from(state) / f64::from(u32::MAX) - 0.5)]
        })
        .collect()
}

fn logs(all: &[(&str, Vec<Sample>)]) -> Dataset {
    let texts: Vec<(&str, String)> = all.iter().map(|(name, samples)| (*name, csv(samples))).collect();
    let texts: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (*name, text.as_str())).collect();
    read_all(&texts, &RequestedRoles::default()).unwrap()
}

fn identified(data: &Dataset, models: &[&str]) -> Identification {
    let models = models.iter().map(|m| (*m).to_string()).collect();
    identify(data, &Options { seed: 1, models, ..Options::default() }, &|_, _| {}).unwrap()
}

const BAND: [f64; 2] = [0.7, 0.9];

#[test]
fn a_known_cell_comes_back_from_noisy_logs_with_gaps() {
    let mut first = cable(1500, 0.0, BAND, 0.05);
    // Five seconds are missing.
    first.drain(600..1100);
    let data = logs(&[("a.csv", first), ("b.csv", cable(1500, 1.0, BAND, 0.05))]);
    assert_eq!(data.sequences.len(), 3, "the gap cuts");
    let found = identified(&data, &["cell"]);
    let cell = found.model.estimator.law.cell.unwrap();
    // The basis is the near tension and the constant.
    for (fitted, truth) in [(cell.low[0], BAND[0]), (cell.high[0], BAND[1])] {
        assert!((fitted - truth).abs() < 0.01, "{cell:?}");
    }
    assert!(cell.low[1].abs() < 0.05 && cell.high[1].abs() < 0.05, "{cell:?}");
    assert!(cell.branches.len() == 1);
}

/// Four trials of a cable at each of several loads from `first` on, whose gain depends on the load.
fn loaded(first: u32, loads: u32) -> String {
    let mut text = String::from("time_s,tension_in_n,tension_out_n,trial,load_pct\n");
    for trial in 0..4 * loads {
        let load = first + 10 * (trial / 4);
        let gain = 0.8 + 0.001 * f64::from(load);
        for [t, near, far] in cable(300, f64::from(trial), [gain - 0.1, gain + 0.1], 0.05) {
            let size = f64::from(load) / 40.0;
            text += &format!("{t},{},{},{trial},{load}\n", size * near, size * far);
        }
    }
    text
}

#[test]
fn beyond_the_loads_of_the_logs_the_expected_error_and_the_band_grow() {
    let read = |text: &str| {
        let requested = RequestedRoles { trial: Some("trial".into()), ..RequestedRoles::default() };
        read_all(&[("loads.csv", text)], &requested).unwrap()
    };
    let found = identified(&read(&loaded(40, 3)), &["cell"]);
    let outside = found.model.outside.clone().unwrap();
    assert!(outside.band_factor >= found.model.band_factor);
    let named: Vec<(&str, f64, f64)> =
        outside.sides.iter().map(|side| (side.column.as_str(), side.outermost, side.step)).collect();
    assert_eq!(named, [("load_pct", 60.0, 10.0), ("load_pct", 40.0, -10.0)]);
    assert_eq!(found.report.beyond, outside.sides);
    // A log of one load: its condition is known by the name of the column.
    for (load, steps) in [(50, 0.0), (90, 3.0), (10, 3.0)] {
        let text = loaded(load, 1);
        let options = ReadOptions {
            conditions: conditions_of(&found.model),
            far_required: true,
            ..ReadOptions::default()
        };
        let one = read_bytes_with_roles(&[("one.csv", text.as_bytes())], &roles_of(&found.model), &options);
        let scores = evaluate(&found.model, &one.unwrap(), None).unwrap().overall;
        let side = &outside.sides[usize::from(load < 40)];
        let least = found.model.provenance.rmse_unseen;
        let expected = if steps > 0.0 { least.max(side.rmse * f64::powf(steps, 1.5)) } else { least };
        assert!((scores.expected.unwrap() - expected).abs() < 1e-9 * expected, "{load}: {scores:?}");
        assert!(steps > 0.0 || scores.coverage95.unwrap() > 0.9, "{load}: {scores:?}");
    }
}

#[test]
fn a_foreign_log_is_left_out_and_named() {
    let ours = |phase| cable(900, phase, BAND, 0.02);
    let mut all =
        vec![("a.csv", ours(0.0)), ("b.csv", ours(0.9)), ("c.csv", ours(1.8)), ("d.csv", ours(2.7))];
    let clean = identified(&logs(&all), &["cell"]);
    assert!(clean.report.influence.iter().all(|row| !row.dropped));
    all.insert(2, ("other.csv", cable(900, 0.4, [0.3, 0.45], 0.02)));
    let found = identified(&logs(&all), &["cell"]);
    let dropped: Vec<&str> =
        found.report.influence.iter().filter(|row| row.dropped).map(|row| row.log.as_str()).collect();
    assert_eq!(dropped, ["other.csv"]);
    assert!(!found.model.provenance.logs.contains(&"other.csv".to_string()));
    // Without it the fit is that of the others alone.
    let cells = [&clean, &found].map(|f| f.model.estimator.law.cell.clone().unwrap());
    assert!((cells[0].low[0] - cells[1].low[0]).abs() < 1e-9);
}

#[test]
fn a_log_alone_in_its_condition_is_kept_and_judged_with_its_figures() {
    let at = |bend: u32, samples: &[Sample]| -> String {
        let lines = csv(samples);
        let rows = lines.lines().enumerate();
        rows.map(|(k, row)| if k == 0 { format!("{row},sheath_deg\n") } else { format!("{row},{bend}\n") })
            .collect()
    };
    let ours = |phase| cable(900, phase, BAND, 0.02);
    let other = cable(900, 0.4, [0.3, 0.45], 0.02);
    let read = |bend: u32| {
        let texts = [0.0, 0.9, 1.8, 2.7].map(|phase| at(60, &ours(phase)));
        let other = at(bend, &other);
        let names = ["a.csv", "b.csv", "c.csv", "d.csv"];
        let mut all: Vec<(&str, &str)> = names.into_iter().zip(texts.iter().map(String::as_str)).collect();
        all.push(("other.csv", &other));
        let flags = RequestedRoles {
            effort: vec!["tension_in_n".into()],
            given: vec!["sheath_deg".into()],
            ..RequestedRoles::default()
        };
        identified(&read_all(&all, &flags).unwrap(), &["linear"]).report
    };
    let report = read(180);
    let row = report.influence.iter().find(|row| row.log == "other.csv").unwrap();
    assert!(!row.dropped, "{row:?}");
    // Where the bend tells the two apart, the other recording may even help: a remark is due only above the
    // limit.
    assert_eq!(
        row.remark.contains("no other log has its value of `sheath_deg`"),
        row.influence > 0.4,
        "{row:?}"
    );
    let same = read(60);
    assert!(same.influence.iter().any(|row| row.log == "other.csv" && row.dropped), "{:?}", same.influence);
}

#[test]
fn a_far_side_without_relation_is_not_recommended_and_a_log_without_reversal_with_care() {
    use sinew_identify::report::Grade;
    let noise = |phase: f64| -> Vec<Sample> {
        let unrelated = cable(900, phase + 40.0, BAND, 0.0).into_iter().rev();
        cable(900, phase, BAND, 0.0).iter().zip(unrelated).map(|(a, b)| [a[0], a[1], b[2].sin()]).collect()
    };
    let data = logs(&[("a.csv", noise(0.0)), ("b.csv", noise(1.3)), ("c.csv", noise(2.9))]);
    let report = identified(&data, &["cell"]).report;
    assert_eq!(report.grade, Grade::DoNotUse);
    let headline = report.headline.unwrap();
    assert!(
        headline.withdrawn.is_some() && headline.in_words().starts_with("No law's parameters"),
        "{headline:?}"
    );
    assert!(report.recommendations[0].starts_with("Do not use the model"), "{:?}", report.recommendations);
    let beside: Vec<&str> = report.candidates.iter().map(|c| c.name.as_str()).collect();
    assert!(beside.contains(&"constant") && beside.contains(&"linear"), "{beside:?}");

    let ramp: Vec<Sample> = (0..900)
        .map(|i| [0.01 * f64::from(i), 2.0 + 0.01 * f64::from(i), 1.6 + 0.008 * f64::from(i)])
        .collect();
    let longer: Vec<Sample> = ramp.iter().map(|[t, near, far]| [*t, near * 1.1, far * 1.1]).collect();
    let report = identified(&logs(&[("a.csv", ramp), ("b.csv", longer)]), &["cell"]).report;
    assert_ne!(report.grade, Grade::Use);
    assert!(report.warnings.iter().any(|w| w.contains("never reverses")), "{:?}", report.warnings);

    let good = logs(&[("a.csv", cable(1500, 0.0, BAND, 0.02)), ("b.csv", cable(1500, 1.0, BAND, 0.02))]);
    let report = identified(&good, &["cell"]).report;
    assert_eq!(report.grade, Grade::Use, "{:?}", report.recommendations);
    assert!(report.chosen.reason.starts_with("cell was chosen"), "{}", report.chosen.reason);
}

#[test]
fn a_law_without_memory_says_that_its_structure_is_wrong() {
    let data = logs(&[("a.csv", cable(1500, 0.0, BAND, 0.02)), ("b.csv", cable(1500, 1.0, BAND, 0.02))]);
    let report = identified(&data, &["cell"]).report;
    let capstan = report.classical.iter().find(|law| law.law.starts_with("static capstan")).unwrap();
    assert!(capstan.remark.contains("structure"), "{}", capstan.remark);
    let play = report.classical.iter().find(|law| law.law == "capstan play").unwrap();
    assert!(!play.remark.contains("structure"), "{}", play.remark);
}

#[test]
fn one_law_gives_the_friction_angle_of_a_log_also_without_a_unit_in_its_header() {
    let truth = 0.5 * (BAND[1] / BAND[0]).ln();
    let texts = [0.0, 1.0, 2.0].map(|phase| csv(&cable(1500, phase, BAND, 0.02)));
    let without = texts.clone().map(|text| text.replacen("tension_in_n,tension_out_n", "near,far", 1));
    for (texts, near, far) in [(texts, "tension_in_n", "tension_out_n"), (without, "near", "far")] {
        let roles = RequestedRoles {
            far: Some(far.to_owned()),
            effort: vec![near.to_owned()],
            ..RequestedRoles::default()
        };
        let named: Vec<(&str, &str)> =
            ["a.csv", "b.csv", "c.csv"].into_iter().zip(texts.iter().map(String::as_str)).collect();
        let report = identified(&read_all(&named, &roles).unwrap(), &["cell"]).report;
        let headline = report.headline.unwrap();
        assert!(headline.withdrawn.is_none() && headline.law == "capstan play", "{headline:?}");
        let angle = &headline.parameters[0];
        assert!(angle.name.starts_with("friction angle") && angle.identified, "{headline:?}");
        assert!(angle.low <= truth && truth <= angle.high, "{angle:?}");
        assert!((angle.value - truth).abs() < 0.02 * truth, "{angle:?}");
        // One number for one quantity: a law that is worse keeps its angle to itself.
        let others = report.classical.iter().filter(|law| law.law == "static capstan");
        let angles = others.flat_map(|law| &law.parameters).filter(|p| p.name.starts_with("friction angle"));
        assert!(angles.clone().count() == 1 && angles.clone().all(|p| !p.identified), "{near}");
        let law = report.candidates.iter().find(|candidate| candidate.name == "capstan play").unwrap();
        assert!(law.law && law.size == 4 && law.fold_rmse.len() == report.folds, "{law:?}");
    }
}

#[test]
fn a_short_calibration_reaches_another_specimen() {
    let data = logs(&[("a.csv", cable(1500, 0.0, BAND, 0.02)), ("b.csv", cable(1500, 1.0, BAND, 0.02))]);
    let old = identified(&data, &["hybrid"]).model;
    // Another tool: more friction, and a far sensor of another gain.
    let other = |n, phase| csv(&cable(n, phase, [0.5, 0.8], 0.02));
    let read = |texts: &[&str]| {
        let logs: Vec<(&str, &[u8])> = texts.iter().map(|text| ("other.csv", text.as_bytes())).collect();
        let options = ReadOptions { far_required: true, ..ReadOptions::default() };
        read_bytes_with_roles(&logs, &roles_of(&old), &options).unwrap()
    };
    let test = other(1500, 2.0);
    let test = read(&[&test]);
    let error = |model| evaluate(model, &test, None).unwrap().overall.percent_of_range.unwrap();
    let calibration: Vec<String> = [0.3, 1.3, 2.3].map(|phase| other(500, phase)).to_vec();
    let calibration: Vec<&str> = calibration.iter().map(String::as_str).collect();
    let options = Options { seed: 1, ..Options::default() };
    let new = adapt(&old, &read(&calibration), &options, &|_, _| {}).unwrap();
    let (before, after) = (error(&old), error(&new.model));
    assert!(before > 12.0, "the other tool is another one: {before} %");
    assert!(after < 3.0, "{before} % -> {after} % by {}", new.model.provenance.member);
    let names: Vec<&str> = new.report.candidates.iter().map(|m| m.name.as_str()).collect();
    assert!(["unchanged", "scaled", "transfer", "fresh"].iter().all(|way| names.contains(way)), "{names:?}");
}

#[test]
fn the_same_specimen_needs_no_adaptation() {
    let data = logs(&[("a.csv", cable(1500, 0.0, BAND, 0.02)), ("b.csv", cable(1500, 1.0, BAND, 0.02))]);
    let old = identified(&data, &["hybrid"]).model;
    let again: Vec<String> = [0.3, 1.3, 2.3].map(|phase| csv(&cable(500, phase, BAND, 0.02))).to_vec();
    let logs: Vec<(&str, &[u8])> = again.iter().map(|text| ("same.csv", text.as_bytes())).collect();
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    let calibration = read_bytes_with_roles(&logs, &roles_of(&old), &options).unwrap();
    let new = adapt(&old, &calibration, &Options { seed: 1, ..Options::default() }, &|_, _| {}).unwrap();
    let error = |model| evaluate(model, &calibration, None).unwrap().overall.rmse.unwrap();
    assert!(error(&new.model) < 1.05 * error(&old), "{} {}", error(&new.model), error(&old));
}

#[test]
fn units_that_the_flags_stated_go_with_the_model() {
    let text = |phase: f64, scale: f64| {
        let rows = cable(1500, phase, BAND, 0.02);
        let row = |[t, near, far]: &Sample| format!("{t},{},{far}\n", near * scale);
        format!("t_s,LC-A,pull\n{}", rows.iter().map(row).collect::<String>())
    };
    let stated = |unit: &str| ReadOptions {
        far_required: true,
        columns: ColumnOptions {
            units: vec![("LC-A".into(), unit.into()), ("pull".into(), "lbf".into())],
            ..ColumnOptions::default()
        },
        ..ReadOptions::default()
    };
    let (effort, far) = (vec!["LC-A".to_owned()], Some("pull".to_owned()));
    let flags = RequestedRoles { far, effort, ..RequestedRoles::default() };
    let [one, two] = [0.0, 1.0].map(|phase| text(phase, 1.0));
    let data = [("a.csv", one.as_bytes()), ("b.csv", two.as_bytes())];
    let model = identified(&read_bytes(&data, &flags, &stated("N")).unwrap(), &["linear"]).model;
    assert_eq!([&model.units["LC-A"], &model.units["pull"]], ["N", "lbf"]);
    let rmse = |unit: &str, scale: f64| {
        let fresh = text(2.0, scale);
        let data = read_bytes_with_roles(&[("c.csv", fresh.as_bytes())], &roles_of(&model), &stated(unit))?;
        let scores = evaluate(&model, &data, None)?;
        assert_eq!(scores.far_unit, "lbf");
        Ok::<_, sinew_identify::Error>(scores.overall.rmse.unwrap())
    };
    let (newtons, kilonewtons) = (rmse("N", 1.0).unwrap(), rmse("kN", 1e-3).unwrap());
    assert!((newtons - kilonewtons).abs() < 1e-9, "{newtons} {kilonewtons}");
    let said = rmse("mm", 1.0).unwrap_err().to_string();
    assert!(said.contains("`LC-A` is in mm, but the model has it in N"), "{said}");
}
