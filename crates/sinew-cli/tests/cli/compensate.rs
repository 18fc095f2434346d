//! `sinew compensate`: what is desired in, commands out, which `sinew predict` returns to what was desired.

use crate::bench::Bench;
use serde_json::Value;
use sinew::predictor::{
    CableColumns, CableModel, Estimator, Input, InputLimits, MemoryLaw, Model, ObservedCable, Role,
};

/// A desired far tension with ramps, a reversal and a stretch at rest.
fn desired(rows: u32) -> String {
    let mut text = "time_s,tension_out_n\n".to_owned();
    for k in 0..rows {
        let t = f64::from(k) * 0.01;
        text += &format!("{t},{}\n", 30.0 + 10.0 * (1.3 * t.min(2.5)).sin());
    }
    text
}

/// The cells of a table, with its head.
fn table(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

#[test]
fn commands_are_in_the_models_own_columns_and_predict_to_what_is_desired() {
    let bench = Bench::with_model();
    bench.write("desired.csv", desired(500));
    bench.succeeds("compensate out/model.json desired.csv --max-rate 500 --out command.csv");
    bench.succeeds("predict out/model.json command.csv --out check.csv");
    let (head, rows) = table(&bench.read("command.csv"));
    let names = "time_s,tension_in_n,tension_out_n,command_low,command_high,gate,flags";
    assert_eq!(head.join(","), names);
    let (_, predicted) = table(&bench.read("check.csv"));
    assert_eq!((rows.len(), predicted.len()), (500, 500));
    let number = |cell: &String| cell.parse::<f64>().unwrap();
    let mut attained = 0;
    for (row, said) in rows.iter().zip(&predicted) {
        assert!(number(&row[3]) <= number(&row[1]) && number(&row[1]) <= number(&row[4]), "{row:?}");
        if !row[6].contains("not_attainable") {
            attained += 1;
            assert!((number(&row[2]) - number(&said[3])).abs() < 1e-6 * 100.0, "{row:?} {said:?}");
        }
    }
    assert!(attained > 440, "{attained}");
    let steps = rows.windows(2).map(|pair| (number(&pair[1][1]) - number(&pair[0][1])).abs());
    assert!(steps.fold(0.0, f64::max) <= 5.0 + 1e-9);
}

#[test]
fn a_constant_desire_one_row_and_a_near_side_that_was_measured_are_taken() {
    let bench = Bench::with_model();
    bench.write(
        "held.csv",
        (0..50).fold("time_s,tension_out_n\n".to_owned(), |t, k| t + &format!("{k},35\n")),
    );
    bench.write("one.csv", "time_s,tension_out_n\n0,35\n");
    bench.write("gaps.csv", "time_s,tension_out_n\n0,35\n0.01,\n0.02,36\n");
    bench.write("measured.csv", "time_s,tension_out_n,tension_in_n\n0,35,50\n0.01,35,50\n0.02,36,\n");
    for (name, rows) in [("held", 50), ("one", 1), ("gaps", 3), ("measured", 3)] {
        let text = bench.succeeds(&format!("compensate out/model.json {name}.csv --out c.csv --json")).stdout;
        let answer: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (answer["commands"].as_u64(), answer["near"].as_str()),
            (Some(rows), Some("tension_in_n"))
        );
        assert_eq!(bench.read("c.csv").lines().count(), rows as usize + 1);
    }
}

/// The file of a model by the observer of the paper's cable.
fn observer(bench: &Bench) -> String {
    let mut model = Model::from_json(&bench.read("out/model.json")).unwrap();
    let columns = CableColumns {
        tension: 0,
        motor: 1,
        anchor: 2,
        tension_scale: 1.0,
        motor_scale: 1.0,
        anchor_scale: 1.0,
    };
    let cable = Some(ObservedCable { columns, model: CableModel::bench() });
    let law = MemoryLaw { signals: vec![], cell: None, cable, axis: None, features: vec![] };
    model.estimator = Estimator { sigma0: 1.0, ..Estimator::of(law) };
    let inputs =
        [("tension_in_n", Role::Effort), ("motor_m", Role::Motion), ("anchor_m", Role::Anchor)].into_iter();
    model.inputs = inputs.map(|(column, role)| Input { column: column.to_owned(), role }).collect();
    let limits = |jump: f64, high: f64| InputLimits { jump, low: -high, high, typical: 0.0 };
    model.guards = vec![limits(100.0, 400.0), limits(0.1, 1.0), limits(0.1, 1.0)];
    (model.specimen, model.outside) = (None, None);
    model.to_json().unwrap()
}

#[test]
fn a_planned_motion_crosses_the_dead_band_before_it_turns() {
    let bench = Bench::with_model();
    bench.write("cable.json", observer(&bench));
    // Two trials of strokes at a constant tension; the first is longer.
    let mut text = "trial,time_s,anchor_m,tension_out_n\n".to_owned();
    for (trial, rows) in [(1, 1600), (2, 900)] {
        for k in 0..rows {
            let t = f64::from(k) * 0.005;
            text += &format!("{trial},{t},{},80\n", 0.05 * (2.0 * t).sin());
        }
    }
    bench.write("strokes.csv", text);
    let error = |preview: &str| {
        let command =
            format!("compensate cable.json strokes.csv --max-rate 0.1 {preview} --out c.csv --json");
        let answer: Value = serde_json::from_str(&bench.succeeds(&command).stdout).unwrap();
        assert_eq!(answer["commands"], 2500);
        let error = &answer["error"];
        let [rms, p95, largest] = ["rms", "p95", "largest"].map(|name| error[name].as_f64().unwrap());
        assert!(0.0 < rms && rms < largest && p95 <= largest, "{error}");
        rms
    };
    let (causal, planned, late) = (error(""), error("--preview 0.08"), error("--preview 100"));
    assert!(planned < 0.8 * causal, "{planned} {causal}");
    assert!(late > causal, "the direction at the end of a trial is no plan: {late} {causal}");
}

#[test]
fn what_cannot_be_compensated_is_one_error_and_leaves_no_file() {
    let bench = Bench::with_model();
    bench.write("desired.csv", desired(30));
    bench.write("other.csv", "time_s,tension_far_n\n0,1\n1,2\n");
    bench.write("words.json", "{}");
    let refused = [
        ("out/model.json other.csv", "tension_out_n"),
        ("out/model.json nowhere.csv", "nowhere.csv"),
        ("words.json desired.csv", "words.json"),
        ("out/model.json desired.csv --near luck", "--near to be one of tension_in_n"),
        ("out/model.json desired.csv --min 9 --max 3", "max"),
        ("out/model.json desired.csv --preview 0.1", "expected the observer of a cable"),
    ];
    for (arguments, said) in refused {
        bench.refuses(&format!("compensate {arguments} --out c.csv"), &[said]);
    }
    for (arguments, said) in [
        ("--max-rate 0", "> 0"),
        ("--tolerance -1", ">= 0"),
        ("--min x", "a finite number"),
        ("--preview 0", "> 0"),
    ] {
        let command = format!("compensate out/model.json desired.csv --out c.csv {arguments}");
        bench.refuses_usage(&command, &[said]);
    }
    bench.refuses("compensate out/model.json desired.csv --out desired.csv", &["desired.csv"]);
}
