//! The 95 % intervals of the static capstan cover the parameters of simulated logs, whatever motion and
//! noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sinew_identify::fit::classical::{Parameter, fit_classical_law};
use sinew_identify::log::{Dataset, Input, Role, Roles, Sequence};
use std::f64::consts::TAU;

/// `mu phi` and `T_0`, N.
const TRUTH: [f64; 2] = [0.35, 5.0];

/// Motion of the near side and errors of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Case {
    Sine,
    Triangle,
    ColouredNoise,
    NoisyInput,
    Quantised,
    Holds,
}

const CASES: [Case; 6] =
    [Case::Sine, Case::Triangle, Case::ColouredNoise, Case::NoisyInput, Case::Quantised, Case::Holds];

/// 60 s at 100 Hz of a cable that slides whenever its near tension changes, and keeps its far tension at
/// rest.
fn log(case: Case, seed: u64) -> Dataset {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let phase: f64 = random.random::<f64>() * TAU;
    let period = 2.0 + 2.0 * random.random::<f64>();
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let n = 6000;
    let wave = |t: f64| -> f64 {
        let turn = (t / period + phase / TAU).fract();
        match case {
            Case::Triangle => 4.0 * (turn - 0.5).abs() - 1.0,
            // Half a stroke, a hold of two seconds, and so on.
            Case::Holds => {
                let cycle = period + 4.0;
                let at = (t + phase) % cycle;
                let half = 0.5 * period;
                if at < half {
                    2.0 * at / half - 1.0
                } else if at < half + 2.0 {
                    1.0
                } else if at < period + 2.0 {
                    1.0 - 2.0 * (at - half - 2.0) / half
                } else {
                    -1.0
                }
            }
            _ => (TAU * turn).sin(),
        }
    };
    let near: Vec<f64> = (0..n).map(|i| 60.0 + 30.0 * wave(f64::from(i) * 0.01)).collect();
    let (mut direction, mut coloured) = (1.0, 0.0);
    let (mut inputs, mut far) = (Vec::new(), Vec::new());
    for i in 0..near.len() {
        let change = near[(i + 1).min(near.len() - 1)] - near[i.max(1) - 1];
        if change.abs() > 1e-9 {
            direction = change.signum();
        }
        coloured += 0.05 * (normal() - coloured);
        let noise = if case == Case::ColouredNoise { 2.0 * coloured } else { 0.3 * normal() };
        let mut measured = near[i] + if case == Case::NoisyInput { 0.2 * normal() } else { 0.0 };
        let mut seen = near[i] * f64::exp(-direction * TRUTH[0]) + TRUTH[1] + noise;
        if case == Case::Quantised {
            (measured, seen) = ((2.0 * measured).round() / 2.0, (2.0 * seen).round() / 2.0);
        }
        inputs.push(measured);
        far.push(seen);
    }
    let sequence = Sequence {
        log: 0,
        trial: String::new(),
        row: (0..near.len()).collect(),
        time_s: (0..n).map(|i| f64::from(i) * 0.01).collect(),
        inputs,
        far: far.clone(),
        far_clean: far,
        scored: vec![true; near.len()],
        condition_values: vec![],
    };
    let inputs = vec![Input { column: "tension_in_n".to_owned(), role: Role::Effort }];
    let roles = Roles {
        far: Some("tension_out_n".to_owned()),
        inputs,
        time: None,
        trial: None,
        group: None,
        units: std::collections::BTreeMap::new(),
    };
    Dataset { roles, columns: vec![], logs: vec![], conditions: vec![], sequences: vec![sequence] }
}

fn fitted(case: Case, seed: u64) -> Vec<Parameter> {
    fit_classical_law(&log(case, seed), "static capstan").unwrap().parameters
}

/// Fractions of the intervals of `mu phi` and of `T_0` that cover their value.
fn coverage(case: Case, seeds: u64) -> [f64; 2] {
    let mut covered = [0_u32; 2];
    for seed in 0..seeds {
        for (k, p) in fitted(case, seed).iter().enumerate() {
            assert!(p.identified, "{case:?} {seed}: {p:?}");
            covered[k] += u32::from(p.low <= TRUTH[k] && TRUTH[k] <= p.high);
        }
    }
    covered.map(|count| f64::from(count) / seeds as f64)
}

#[test]
fn intervals_cover_whatever_motion_and_noise() {
    let fractions = CASES.map(|case| (case, coverage(case, 40)));
    assert!(
        fractions.iter().all(|(_, fraction)| fraction.iter().all(|fraction| *fraction >= 0.85)),
        "{fractions:?}"
    );
}

#[test]
fn long_intervals_cover_in_90_to_98_percent() {
    if std::env::var_os("SINEW_LONG").is_none() {
        return;
    }
    for case in CASES {
        let fraction = coverage(case, 200);
        println!("{case:?}: mu phi {:.1} %, T_0 {:.1} %", 100.0 * fraction[0], 100.0 * fraction[1]);
        assert!(fraction.iter().all(|fraction| (0.9..=0.98).contains(fraction)), "{case:?}: {fraction:?}");
    }
}
