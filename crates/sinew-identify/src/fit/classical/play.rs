//! Play: the far side is held between two lines of the near side, at rest between them or on a spring.

use super::law::{FRICTION_ANGLE, Law, PRETENSION, STIFFNESS, Scale, Spec, linear_fit};
use super::samples::{Samples, Signals};
use sinew::transmission::Band;

/// `y <- clamp(y, a1 x + b1, a2 x + b2)`, started at the measured far side; with presliding `y + k dx` in the
/// place of `y`.
pub(super) fn play(samples: &Samples, signals: &Signals, presliding: bool) -> Law {
    let slope_unit = format!("{}/{}", signals.far_unit, signals.near_unit);
    let slope_unit = if signals.near_is_like_far() { "1" } else { &slope_unit };
    let slope = Scale::Linear { typical: signals.far_range / signals.near_range.max(1e-300) };
    let offset = Scale::Linear { typical: signals.far_range };
    let near = if signals.near_is_effort { "T_in" } else { "x" };
    let mut law = Law {
        name: match (signals.near_is_effort, presliding) {
            (true, false) => "capstan play",
            (true, true) => "capstan play with presliding",
            (false, _) => "backlash play",
        }
        .to_owned(),
        equation: format!(
            "y <- clamp(y{}, a1 {near} + b1, a2 {near} + b2), {near} = {}",
            if presliding { format!(" + k d{}", signals.drive_name) } else { String::new() },
            signals.near_name
        ),
        specs: vec![
            Spec::friction("slope of the lower line (a1)", slope_unit, slope),
            Spec::friction("offset of the lower line (b1)", &signals.far_unit, offset),
            Spec::friction("slope of the upper line (a2)", slope_unit, slope),
            Spec::friction("offset of the upper line (b2)", &signals.far_unit, offset),
        ],
        starts: starts(samples),
        predict: Box::new(predict),
        derived: vec![],
        undetermined: vec![],
        note: String::new(),
        sliding_only: false,
        reason: |i| match i {
            0 | 1 => "the lower line is rarely active",
            2 | 3 => "the upper line is rarely active",
            _ => "reversals are too sharp or too few for it",
        },
    };
    if presliding {
        let unit = format!("{}/{}", signals.far_unit, signals.drive_unit);
        let unit = if signals.has_motion { unit.as_str() } else { slope_unit };
        let typical = signals.far_range / signals.drive_range.max(1e-300);
        law.specs.push(Spec::friction(STIFFNESS, unit, Scale::Linear { typical }));
        let stiff = 2.0 * typical * sense(samples);
        let with = |start: &Vec<f64>| [0.0, stiff].map(|k| [start.as_slice(), &[k]].concat());
        law.starts = law.starts.iter().flat_map(with).collect();
    }
    if signals.near_is_like_far() {
        law.derived = vec![
            (Spec::friction(FRICTION_ANGLE, "1", Scale::Linear { typical: 0.5 }), |p| {
                if p[0] > 0.0 { 0.5 * (p[2] / p[0]).ln() } else { f64::NAN }
            }),
            (Spec::friction("gain between the two sensors", "1", Scale::Linear { typical: 0.5 }), |p| {
                if p[0] > 0.0 { (p[0] * p[2]).sqrt() } else { f64::NAN }
            }),
            (Spec::new(PRETENSION, &signals.far_unit, offset), |p| 0.5 * (p[1] + p[3])),
        ];
    }
    law
}

fn predict(samples: &Samples, p: &[f64], out: &mut [f64]) -> bool {
    let mut crossed = 0;
    for run in &samples.runs {
        let first = samples.far[run.start];
        // Without a measured start, mid-band.
        let mut state = if first.is_finite() { first } else { f64::NAN };
        let stiffness = p.get(4).copied().unwrap_or(0.0);
        let mut before = samples.drive[run.start];
        for row in run.clone() {
            state += stiffness * (samples.drive[row] - before);
            before = samples.drive[row];
            let (low, high) = (p[0] * samples.near[row] + p[1], p[2] * samples.near[row] + p[3]);
            crossed += usize::from(high < low);
            let trial = if state.is_finite() { state } else { 0.5 * (low + high) };
            (state, _) = Band::new(low, high).project(trial, 1.0);
            out[row] = state;
        }
    }
    // With crossed lines the law is not a play.
    crossed <= out.len() / 10
}

/// 1 where the far side rises with the drive, else -1.
fn sense(samples: &Samples) -> f64 {
    let pairs = samples.fitted.windows(2).filter(|pair| pair[0] + 1 == pair[1]);
    let change = |values: &[f64], pair: &[usize]| values[pair[1]] - values[pair[0]];
    let product: f64 = pairs.map(|pair| change(&samples.drive, pair) * change(&samples.far, pair)).sum();
    if product < 0.0 { -1.0 } else { 1.0 }
}

/// Lines a little below and above the least-squares line, shifted or turned.
fn starts(samples: &Samples) -> Vec<Vec<f64>> {
    let near: Vec<f64> = samples.fitted.iter().map(|&row| samples.near[row]).collect();
    let far: Vec<f64> = samples.fitted.iter().map(|&row| samples.far[row]).collect();
    let ones = vec![1.0; near.len()];
    let Some((line, squares)) = linear_fit(&[near, ones], &far) else {
        return vec![vec![0.5, 0.0, 1.5, 0.0]];
    };
    let spread = (squares / far.len().max(1) as f64).sqrt();
    let mut starts = vec![];
    for d in [0.3, 1.0, 2.0] {
        starts.push(vec![line[0], line[1] - d * spread, line[0], line[1] + d * spread]);
        let turn = 0.4 * d * line[0].signum();
        starts.push(vec![line[0] * (1.0 - turn), line[1], line[0] * (1.0 + turn), line[1]]);
    }
    starts
}
