//! What the motion of the logs can show at all: reversals, strokes and speeds of the near side.

use crate::conditioning::ConditionedLogs;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use sinew::predictor::{Model, Role};

/// Fraction of the range by which a signal must turn back for a reversal.
const REVERSAL: f64 = 0.05;

/// Fewest reversals, in all logs together, that show friction in both directions.
const FEWEST_REVERSALS: usize = 4;

/// Fewest samples that count.
const FEWEST_SAMPLES: usize = 300;

/// Fewest samples of a stroke, in the median of a log, with which the dead band after a reversal is seen.
const FEWEST_OF_STROKE: usize = 10;

/// Ratio of the 90 % to the 10 % quantile below which strokes have one length, or one speed.
const ONE: f64 = 1.2;

/// Motion of one signal between two reversals.
struct Stroke {
    length: f64,
    duration_s: f64,
    samples: usize,
}

/// What the logs do not show, in sentences without a full stop; empty for rich logs.
///
/// The first motion is examined, or without one the first effort; a stroke ends where the signal turns back
/// by 5 % of its range.
pub(super) fn limits(logs: &ConditionedLogs, model: &Model) -> Vec<String> {
    let with = |role: Role| model.inputs.iter().position(|input| input.role == role);
    let Some(input) = with(Role::Motion).or_else(|| with(Role::Effort)) else { return Vec::new() };
    let name = &model.inputs[input].column;
    let range = model.guards[input].high - model.guards[input].low;
    let strokes: Vec<Vec<Stroke>> =
        logs.runs.iter().map(|run| strokes(run, input, REVERSAL * range)).collect();
    let reversals: usize = strokes.iter().map(|run| run.len().saturating_sub(1)).sum();
    let samples = logs.runs.iter().flat_map(|run| &run.weight).filter(|w| **w > 0.0).count();
    let mut limits = Vec::new();
    if reversals == 0 {
        limits.push(format!("`{name}` never reverses, so friction is seen in one direction only"));
    } else if reversals < FEWEST_REVERSALS {
        limits.push(format!(
            "`{name}` reverses {reversals} times in all logs, expected {FEWEST_REVERSALS} and more"
        ));
    }
    limits.extend(coarse(logs, input, range, name));
    if samples < FEWEST_SAMPLES {
        limits.push(format!("{samples} samples count, expected {FEWEST_SAMPLES} and more"));
    }
    // The first and the last stroke of a log are cut off.
    let whole = || strokes.iter().flat_map(|run| run.get(1..run.len().saturating_sub(1)).unwrap_or_default());
    if reversals >= FEWEST_REVERSALS && whole().count() >= 3 {
        if spread(whole().map(|stroke| stroke.length)) < ONE {
            limits.push(format!(
                "all strokes of `{name}` have one length, so no minor loop of the hysteresis is seen"
            ));
        }
        if spread(whole().map(|stroke| stroke.length / stroke.duration_s.max(1e-12))) < ONE {
            limits.push(format!("all strokes of `{name}` have one mean speed, so its effect is not seen"));
        }
    }
    limits
}

/// The log that is sampled too rarely for its reversals, if there is one: the one of the fewest samples in a
/// stroke.
fn coarse(logs: &ConditionedLogs, input: usize, range: f64, name: &str) -> Option<String> {
    let of_log = |log: usize| -> Option<(usize, usize)> {
        let runs = logs.runs.iter().filter(|run| run.log == log);
        let found = runs.map(|run| strokes(run, input, REVERSAL * range));
        // The first and the last stroke are cut off.
        let whole = found.flat_map(|run| {
            run.get(1..run.len().saturating_sub(1))
                .unwrap_or_default()
                .iter()
                .map(|s| s.samples)
                .collect::<Vec<_>>()
        });
        let mut samples: Vec<usize> = whole.collect();
        samples.sort_unstable();
        let median = *samples.get(samples.len() / 2)?;
        (samples.len() >= 3 && median < FEWEST_OF_STROKE).then_some((median, log))
    };
    let (median, log) = (0..logs.data.logs.len()).filter_map(of_log).min()?;
    let info = &logs.data.logs[log];
    Some(format!(
        "`{name}` of {} reverses every {median} samples, at {:.3} Hz: the rate is too low for the reversals, \
            expected {FEWEST_OF_STROKE} samples and more in a stroke",
        info.name,
        info.interval_s.recip()
    ))
}

/// The strokes of one run between reversals of more than `threshold`.
fn strokes(run: &Run, input: usize, threshold: f64) -> Vec<Stroke> {
    let mut strokes = Vec::new();
    let (mut time, mut started, mut turned) = (0.0, 0.0, 0.0);
    let (mut started_row, mut turned_row) = (0, 0);
    let (mut from, mut extreme, mut direction) = (f64::NAN, f64::NAN, 0.0);
    for row in 0..run.len() {
        let u = run.row(row)[input];
        time += run.dt_s[row];
        if from.is_nan() {
            (from, extreme) = (u, u);
        }
        if (u - extreme) * direction >= 0.0 && direction != 0.0 {
            (extreme, turned, turned_row) = (u, time, row);
        } else if (u - extreme).abs() > threshold {
            if direction != 0.0 {
                strokes.push(Stroke {
                    length: (extreme - from).abs(),
                    duration_s: turned - started,
                    samples: turned_row - started_row,
                });
                (from, started, started_row) = (extreme, turned, turned_row);
            }
            direction = (u - extreme).signum();
            (extreme, turned, turned_row) = (u, time, row);
        }
    }
    if direction != 0.0 {
        let samples = turned_row - started_row;
        strokes.push(Stroke { length: (extreme - from).abs(), duration_s: turned - started, samples });
    }
    strokes
}

/// Ratio of the 90 % to the 10 % quantile.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let edge = quantiles(values.collect(), &[0.1, 0.9]);
    edge[1] / edge[0].max(1e-300)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(signal: impl Fn(f64) -> f64) -> Run {
        let inputs: Vec<f64> = (0..2000).map(|i| signal(f64::from(i) * 0.01)).collect();
        let n = inputs.len();
        let dt_s = (0..n).map(|i| if i == 0 { 0.0 } else { 0.01 }).collect();
        Run { log: 0, dt_s, far: inputs.clone(), weight: vec![1.0; n], inputs, width: 1 }
    }

    #[test]
    fn strokes_lie_between_reversals_and_noise_makes_none() {
        let noisy = run(|t| (t * core::f64::consts::PI).sin() + 0.02 * (t * 173.0).sin());
        let found = strokes(&noisy, 0, 0.1);
        assert_eq!(found.len(), 21, "twenty reversals in 20 s at 0.5 Hz");
        assert!(
            found[1..20].iter().all(|s| (s.length - 2.0).abs() < 0.1 && (s.duration_s - 1.0).abs() < 0.1)
        );
        assert!(spread(found[1..20].iter().map(|s| s.length)) < ONE);
        assert_eq!(strokes(&run(|t| t), 0, 1.0).len(), 1, "one direction");
        assert!(strokes(&run(|_| 3.0), 0, 1.0).is_empty());
        let growing = strokes(&run(|t| t * (t * 3.0).sin()), 0, 1.0);
        assert!(spread(growing.iter().map(|s| s.length)) > ONE);
    }
}
