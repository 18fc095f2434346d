//! What to expect beyond the conditions of the logs.

use super::evidence::Evidence;
use crate::select::folds::numeric_quantities;
use serde::Serialize;

/// Growth of the error with the distance from the logs: faster than linear, slower than quadratic.
const POWER: f64 = 1.5;

/// The error to expect on one side of a condition.
///
/// ```text
/// e(d) = e_1 max(1, (d / d_1)^1.5)
/// ```
///
/// `e_1` is the error on the outermost value where it was held out, `d_1` its distance from the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// The condition or given quantity.
    pub column: String,
    /// The outermost value in the logs.
    pub outermost: f64,
    /// `d_1`, with the sign of the side.
    pub step: f64,
    /// `e_1`, far unit.
    pub rmse: f64,
}

impl Beyond {
    /// Root mean square error to expect at a value, far unit; inside the logs `e_1`.
    #[must_use]
    pub fn expected(&self, value: f64) -> f64 {
        let distance = (value - self.outermost) / self.step;
        self.rmse * distance.max(1.0).powf(POWER)
    }
}

/// Either side of every condition that is a number and was held out at its end.
pub(super) fn beyond(evidence: &Evidence<'_>) -> Vec<Beyond> {
    let (data, folds) = (&evidence.logs.data, evidence.folds);
    let mut all = Vec::new();
    if !folds.grouped {
        return all;
    }
    for (column, values) in numeric_quantities(data) {
        for sign in [1.0, -1.0] {
            let extreme = |list: &mut dyn Iterator<Item = f64>| list.fold(f64::MIN, |m, v| m.max(sign * v));
            let finite = || values.iter().copied().filter(|v| v.is_finite());
            let outermost = extreme(&mut finite());
            let side = |held: &Vec<Option<(usize, usize)>>| {
                let pairs = values.iter().zip(held);
                let mut kept = pairs.filter(|(v, h)| h.is_none() && v.is_finite()).map(|(v, _)| *v);
                outermost - extreme(&mut kept)
            };
            let steps = folds.held_out.iter().map(side).enumerate();
            let held = steps.filter(|(_, step)| *step > 0.0 && step.is_finite());
            let Some((fold, step)) = held.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            if let Some(rmse) = error_at(evidence, fold, &values, sign * outermost) {
                let (outermost, step) = (sign * outermost, sign * step);
                all.push(Beyond { column: column.clone(), outermost, step, rmse });
            }
        }
    }
    all
}

/// Error of the chosen model on the sequences of one value, as one fold held them out.
#[allow(clippy::float_cmp, reason = "the value is one of those of the sequences")]
fn error_at(evidence: &Evidence<'_>, fold: usize, values: &[f64], value: f64) -> Option<f64> {
    let validation = evidence.scored[evidence.chosen].validation()?;
    let (mut sum, mut count) = (0.0, 0.0);
    let rows = validation.rows().filter(|(sequence, .., f)| *f == fold && values[*sequence] == value);
    for (sequence, row, estimate, _) in rows {
        let run = &evidence.logs.runs[sequence];
        sum += run.weight[row] * (estimate.mean - run.far[row]).powi(2);
        count += run.weight[row];
    }
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// What to expect one step beyond either side, in words; nothing without conditions.
pub(super) fn in_words(beyond: &[Beyond], range: f64) -> String {
    let one = |side: &Beyond| {
        let at = side.outermost + side.step;
        let percent = 100.0 * side.expected(at) / range;
        format!("at `{}` {at} expect {percent:.1} %", side.column)
    };
    let sides: Vec<String> = beyond.iter().map(one).collect();
    if sides.is_empty() { String::new() } else { format!("; beyond them {}", sides.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_grows_beyond_one_step_on_either_side_and_not_before() {
        for sign in [1.0, -1.0] {
            let side = Beyond { column: "load".into(), outermost: 60.0, step: sign * 20.0, rmse: 2.0 };
            let at = |steps: f64| side.expected(60.0 + sign * 20.0 * steps);
            for (steps, factor) in [(-1.0, 1.0), (0.5, 1.0), (1.0, 1.0), (4.0, 8.0)] {
                assert!((at(steps) - 2.0 * factor).abs() < 1e-12, "{sign} {steps}: {}", at(steps));
            }
        }
        let side = Beyond { column: "load".into(), outermost: 60.0, step: 20.0, rmse: 2.0 };
        assert_eq!(in_words(&[side], 50.0), "; beyond them at `load` 80 expect 4.0 %");
        assert!(in_words(&[], 50.0).is_empty());
    }
}
