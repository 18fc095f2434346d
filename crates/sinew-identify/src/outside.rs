//! What holds outside the ranges of the training logs, by what the folds held out there.

use crate::conditioning::{ConditionedLogs, range_of};
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::select::cross_validation::{CrossValidation, FoldScore, band_factor};
use crate::select::folds::{Folds, numeric_quantities};
use sinew::predictor::{Beyond, Estimate, Outside};

/// Fewest samples of a fold outside the ranges of the others that say how wide the band must be.
const FEWEST: usize = 20;

/// What the folds show of a model outside the ranges of the training logs, `inside` the factor of its band
/// within them; none where they show nothing.
pub(crate) fn outside(
    validation: &CrossValidation,
    logs: &ConditionedLogs,
    folds: &Folds,
    inside: f64,
) -> Option<Outside> {
    let ratios = |fold: usize| ratios_outside(validation, &logs.runs, folds, fold);
    let scores: Vec<FoldScore> = (0..validation.outputs.len()).filter_map(ratios).collect();
    let sides = sides(validation, logs, folds);
    let factor = if scores.is_empty() { inside } else { band_factor(&scores, None).max(inside) };
    (!scores.is_empty() || !sides.is_empty()).then_some(Outside { band_factor: factor, sides })
}

/// Errors over standard deviations of what a fold held out, where it lies outside the ranges of what
/// remained; none where that is too little.
fn ratios_outside(
    validation: &CrossValidation,
    runs: &[Run],
    folds: &Folds,
    fold: usize,
) -> Option<FoldScore> {
    let width = runs.first()?.width;
    let kept = |input: usize| {
        let of = |(run, held): (&Run, &Option<(usize, usize)>)| {
            let (from, to) = held.unwrap_or((0, 0));
            let rows = (0..run.len()).filter(|row| !(from..to).contains(row));
            rows.map(|row| run.row(row)[input]).collect::<Vec<f64>>()
        };
        runs.iter().zip(&folds.held_out[fold]).flat_map(of).collect()
    };
    let ranges: Vec<(f64, f64)> = (0..width).map(|input| range_of(kept(input))).collect();
    let mut ratios = Vec::new();
    for stretch in &validation.outputs[fold] {
        let run = &runs[stretch.sequence];
        for (row, estimate) in (stretch.from..).zip(&stretch.estimates) {
            let Estimate { mean, variance, clipped, .. } = *estimate;
            let beyond = run.row(row).iter().zip(&ranges).any(|(u, (low, high))| u < low || u > high);
            if run.weight[row] > 0.0 && (beyond || clipped > 0) {
                ratios.push((mean - run.far[row]).abs() / variance.sqrt().max(1e-300));
            }
        }
    }
    let grid: Vec<f64> = (0..=200).map(|k| f64::from(k) / 200.0).collect();
    (ratios.len() >= FEWEST).then(|| FoldScore {
        fold,
        ratios: quantiles(ratios, &grid),
        ..FoldScore::default()
    })
}

/// Either side of every condition that is a number and was held out at its end.
fn sides(validation: &CrossValidation, logs: &ConditionedLogs, folds: &Folds) -> Vec<Beyond> {
    let mut all: Vec<Beyond> = Vec::new();
    if !folds.grouped {
        return all;
    }
    for (column, values) in numeric_quantities(&logs.data) {
        // A given quantity that is the same throughout every log is a condition, too.
        if all.iter().any(|side| side.column == column) {
            continue;
        }
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
            if let Some(rmse) = error_at(validation, &logs.runs, fold, &values, sign * outermost) {
                let (outermost, step) = (sign * outermost, sign * step);
                all.push(Beyond { column: column.clone(), outermost, step, rmse });
            }
        }
    }
    all
}

/// Error on the sequences of one value, as one fold held them out.
#[allow(clippy::float_cmp, reason = "the value is one of those of the sequences")]
fn error_at(
    validation: &CrossValidation,
    runs: &[Run],
    fold: usize,
    values: &[f64],
    value: f64,
) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    let rows = validation.rows().filter(|(sequence, .., f)| *f == fold && values[*sequence] == value);
    for (sequence, row, estimate, _) in rows {
        let run = &runs[sequence];
        sum += run.weight[row] * (estimate.mean - run.far[row]).powi(2);
        count += run.weight[row];
    }
    (count > 0.0).then(|| f64::sqrt(sum / count))
}
