//! Synthetic identification reports for tests: capstan play with noise.

use sinew_identify::log::{Condition, Input, LogInfo, Role};
use sinew_identify::report::{
    Candidate, ChosenSummary, ClassicalFit, ExpectedError, Grade, IdentificationReport, InfluenceRow,
    InputTrace, Parameter, Trace,
};

/// Deterministic pseudo-random numbers.
struct Noise(u64);

impl Noise {
    /// Uniform in [-1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Nearly normal with standard deviation one.
    fn normal(&mut self) -> f64 {
        (0..6).map(|_| self.next()).sum::<f64>() / 2f64.sqrt()
    }
}

/// A simulated trace of `rows` samples at `interval_s`, exciting the sheath at `hz`.
fn trace(
    log: &str,
    trial: &str,
    (start_s, rows, interval_s): (f64, usize, f64),
    hz: f64,
    seed: u64,
) -> Trace {
    let mut noise = Noise(seed);
    let (mut cell, mut model, mut last, mut reversed, mut sign, mut rate) = (4.0, 4.3, 6.0, 0.0, 1.0, 0.0);
    let mut t = Trace {
        log: log.to_owned(),
        trial: trial.to_owned(),
        near_name: "tension_in_n".to_owned(),
        time_s: Vec::new(),
        near: Vec::new(),
        others: vec![InputTrace { column: "stroke_mm".to_owned(), values: Vec::new() }],
        far: Vec::new(),
        predicted: Vec::new(),
        half_width: Vec::new(),
        gate: Vec::new(),
        near_rate: Vec::new(),
        since_reversal_s: Vec::new(),
        scored: Vec::new(),
    };
    for i in 0..rows {
        let time = start_s + i as f64 * interval_s;
        let phase = std::f64::consts::TAU * hz * time;
        let near = 8.0 - 5.0 * phase.cos() + 1.6 * (0.37 * phase).sin() + 0.02 * noise.normal();
        cell = f64::clamp(cell + 0.06 * (near - last), 0.55 * near, 0.82 * near);
        model = f64::clamp(model, 0.54 * near + 0.03, 0.825 * near - 0.02);
        rate += (1.0 - (-interval_s / 0.05).exp()) * ((near - last) / interval_s - rate);
        let direction = if rate.abs() > 0.4 { rate.signum() } else { sign };
        reversed = if direction * sign < 0.0 { 0.0 } else { reversed + interval_s };
        (sign, last) = (direction, near);
        let uncertainty = (-reversed / 0.4).exp();
        t.time_s.push(time);
        t.near.push(near);
        t.others[0].values.push(12.0 * phase.cos());
        t.far.push(cell + 0.05 * noise.normal());
        t.predicted.push(model + 0.08 * uncertainty * sign);
        t.half_width.push(0.3 + 0.35 * uncertainty);
        t.gate.push((1.0 - 0.7 * uncertainty).clamp(0.0, 1.0));
        t.near_rate.push(rate);
        t.since_reversal_s.push(reversed);
        t.scored.push(i as f64 * interval_s > 1.0);
    }
    t
}

/// Five simulated logs with about `rows` samples each, one of them foreign, one with a gap.
pub(crate) fn simulated(rows: usize) -> IdentificationReport {
    let names =
        ["simulated_a.csv", "simulated_b.csv", "simulated_c.csv", "simulated_d.csv", "simulated_outlier.csv"];
    let mut traces = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let hz = 0.12 + 0.05 * k as f64;
        let (seed, dt) = (7 + k as u64, 60.0 / rows.max(1) as f64);
        if k == 1 {
            traces.push(trace(name, "", (0.0, rows / 2, dt), hz, seed));
            traces.push(trace(name, "", (36.0, rows - rows / 2, dt), hz, seed + 50));
        } else {
            traces.push(trace(name, "", (0.0, rows, dt), hz, seed));
        }
    }
    // An outlier log: another gain, so that its band does not hold.
    if let Some(foreign) = traces.last_mut() {
        foreign.far.iter_mut().for_each(|f| *f *= 1.06);
    }
    report(&names, rows, traces)
}

/// One simulated file with `trials` trials, as a tool bench makes them.
pub(crate) fn many_trials(trials: usize, rows: usize) -> IdentificationReport {
    let dt = 0.01;
    let make = |k: usize| {
        let trial = format!("load {} %, {:.1} Hz", 10 + 10 * (k % 10), 0.1 * (1 + k / 10) as f64);
        trace("simulated_bench.csv", &trial, (0.0, rows, dt), 0.1 * (1 + k / 10) as f64, k as u64)
    };
    let mut report = report(&["simulated_bench.csv"], trials * rows, (0..trials).map(make).collect());
    report.far = "torque_out_Nm".to_owned();
    report.influence.clear();
    report.logs[0].trials = trials;
    report.conditions = vec![Condition {
        column: "load_pct".to_owned(),
        values: (1..=10).map(|k| format!("{}", 10 * k)).collect(),
    }];
    for t in &mut report.traces {
        for column in [&mut t.far, &mut t.predicted, &mut t.half_width] {
            column.iter_mut().for_each(|v| *v *= 0.01);
        }
    }
    report.far_range *= 0.01;
    for c in &mut report.candidates {
        c.rmse *= 0.01;
        c.rmse_in_sample *= 0.01;
        c.fold_rmse.iter_mut().for_each(|f| *f *= 0.01);
    }
    report
}

fn report(names: &[&str], rows: usize, traces: Vec<Trace>) -> IdentificationReport {
    let log = |name: &&str| LogInfo {
        name: (*name).to_owned(),
        samples: rows,
        trials: 1,
        duration_s: 60.0,
        interval_s: 60.0 / rows.max(1) as f64,
        findings: match *name {
            "simulated_b.csv" => vec!["gap of 6.0 s at 30.0 s: states reset".to_owned()],
            "simulated_c.csv" => vec![
                "3 spikes on tension_out_n (largest 41 N at line 1204)".to_owned(),
                "sampling is irregular: 5.1 to 14 ms".to_owned(),
            ],
            _ => Vec::new(),
        },
        defects: Vec::new(),
    };
    IdentificationReport {
        version: "0.1.0".to_owned(),
        seed: 42,
        far: "tension_out_n".to_owned(),
        far_unit: "N".to_owned(),
        inputs: vec![
            Input { column: "tension_in_n".to_owned(), role: Role::Effort },
            Input { column: "stroke_mm".to_owned(), role: Role::Motion },
        ],
        logs: names.iter().map(log).collect(),
        columns: Vec::new(),
        conditions: Vec::new(),
        question: "Each fold holds out one log.".to_owned(),
        folds: 5,
        far_range: 9.4,
        beyond: Vec::new(),
        specimen: Vec::new(),
        expected: ExpectedError { rmse: 0.118, percent_of_range: 1.26 },
        candidates: candidates(),
        influence: names.iter().enumerate().map(influence).collect(),
        classical: classical(),
        headline: None,
        traces,
        warnings: vec![
            "simulated_outlier.csv was excluded: with it the error on the other logs is 4.4 times as large.".to_owned(),
            "tension_in_n and stroke_mm are nearly proportional (r = 0.998): their effects cannot be separated.".to_owned(),
        ],
        grade: Grade::Use,
        recommendations: [
            "Use model.json as it is within 2 to 15 N of near tension.".to_owned(),
            "Record one more log with slow reversals below 3 N, where there are fewer than 200 samples.".to_owned(),
        ],
        chosen: ChosenSummary {
            name: "clamp+net".to_owned(),
            description: "Elastic clamp cell with a gated correction by eight networks.".to_owned(),
            reason: "clamp+net was chosen: the least geometric mean of the errors of all folds.".to_owned(),
            parameters: vec![
                parameter("lower branch gain", "1", 0.5512, 0.5488, 0.5536),
                parameter("upper branch gain", "1", 0.8197, 0.8161, 0.8233),
                parameter("stick stiffness (kappa)", "1", 0.061, 0.048, 0.074),
            ],
            band_factor: 2.31,
            size: 612,
        },
    }
}

fn influence((k, name): (usize, &&str)) -> InfluenceRow {
    let value = [0.03, -0.04, 0.08, 0.11, 1.48][k % 5];
    let dropped = value > 1.0;
    let remark = if dropped { "offset +0.4 N and gain 1.06 against the rest" } else { "" };
    let deviation = 1.4 * value;
    InfluenceRow { log: (*name).to_owned(), influence: value, deviation, dropped, remark: remark.to_owned() }
}

fn parameter(name: &str, unit: &str, value: f64, low: f64, high: f64) -> Parameter {
    let identified = low.is_finite();
    let remark = if identified { "" } else { "no sample slides fast enough" };
    Parameter {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value,
        low,
        high,
        identified,
        remark: remark.to_owned(),
    }
}

fn candidates() -> Vec<Candidate> {
    let row =
        |name: &str, description: &str, percent: f64, coverage: f64, in_sample: f64, folds: [f64; 5]| {
            Candidate {
                name: name.to_owned(),
                description: description.to_owned(),
                chosen: name == "clamp+net",
                law: false,
                size: 12,
                score: percent * 0.09,
                rmse: percent * 0.094,
                percent_of_range: percent,
                pearson: 1.0 - 0.0006 * percent * percent,
                coverage95: coverage,
                fold_rmse: folds.map(|f| f * 0.094).to_vec(),
                rmse_in_sample: in_sample * 0.094,
                failed: None,
            }
        };
    let mut rows = vec![
        row(
            "clamp+net",
            "elastic clamp cell, corrected by gated networks",
            2.14,
            0.961,
            1.42,
            [1.7, 1.9, 2.2, 2.4, 2.5],
        ),
        row(
            "clamp",
            "elastic clamp cell, six physical parameters",
            2.58,
            0.972,
            2.31,
            [2.1, 2.3, 2.6, 2.8, 3.1],
        ),
        row("net:stop", "network on stop operators only", 3.87, 0.881, 0.94, [2.2, 2.6, 3.1, 4.4, 6.9]),
        row(
            "capstan-play",
            "classical capstan with play, four parameters",
            3.12,
            0.955,
            3.02,
            [2.6, 2.8, 3.2, 3.4, 3.6],
        ),
        row(
            "sign-linear",
            "linear with tension times sign of speed",
            11.4,
            0.803,
            10.9,
            [8.2, 9.9, 11.0, 13.1, 14.2],
        ),
        row(
            "linear",
            "straight line, the least one can do",
            14.2,
            0.948,
            14.0,
            [12.1, 13.0, 14.4, 15.1, 16.2],
        ),
    ];
    rows.push(Candidate {
        failed: Some("stiffness left its bounds in 3 of 5 folds".to_owned()),
        score: f64::NAN,
        rmse: f64::NAN,
        percent_of_range: f64::NAN,
        pearson: f64::NAN,
        coverage95: f64::NAN,
        rmse_in_sample: f64::NAN,
        fold_rmse: vec![f64::NAN; 5],
        ..row("lugre", "bristle friction with load dependence", 0.0, 0.0, 0.0, [0.0; 5])
    });
    rows
}

fn classical() -> Vec<ClassicalFit> {
    vec![
        ClassicalFit {
            law: "capstan play".to_owned(),
            equation: "T_out = clamp(T_out, T_in exp(-mu phi) + b1, T_in exp(+mu phi) eta + b2)".to_owned(),
            rmse: 0.284,
            percent_of_range: 3.02,
            parameters: vec![
                parameter("friction angle (mu phi)", "rad", 0.598, 0.591, 0.605),
                parameter("efficiency (eta)", "1", 0.8197, 0.71, 0.93),
                parameter("offset pulling (b1)", "N", 0.03, -0.02, 0.08),
                parameter("offset releasing (b2)", "N", -0.02, -0.11, 0.07),
            ],
            condition: 412.0,
            remark: "mu and phi appear only as a product: mu alone needs the bend angle.".to_owned(),
        },
        ClassicalFit {
            law: "Stribeck and viscous".to_owned(),
            equation: "F = (F_c + (F_s - F_c) exp(-(v/v_s)^2)) sign(v) + c v".to_owned(),
            rmse: 1.02,
            percent_of_range: 10.9,
            parameters: vec![
                parameter("Coulomb force (F_c)", "N", 1.31, 1.22, 1.40),
                parameter("breakaway force (F_s)", "N", 1.52, 0.6, 2.9),
                parameter("Stribeck speed (v_s)", "mm/s", 0.8, f64::NAN, f64::NAN),
                parameter("viscous coefficient (c)", "N·s/m", 2.4e-5, -1.1e-3, 1.2e-3),
            ],
            condition: 3.7e8,
            remark:
                "The logs never slide slower than 1 mm/s for long: the Stribeck terms are not identifiable."
                    .to_owned(),
        },
    ]
}
