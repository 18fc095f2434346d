//! Errors where a model has seen the inputs: beyond them it extrapolates, and says nothing against a log.

use crate::estimation::rmse;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use sinew::predictor::Estimator;

/// Fraction of the samples of a log inside the ranges, from which only these are compared.
const OVERLAP: f64 = 0.2;

/// The ranges of the inputs, between their 1 % and 99 % quantiles.
pub(super) struct Ranges(Vec<(f64, f64)>);

impl Ranges {
    pub(super) fn new(runs: &[&Run]) -> Self {
        let width = runs.first().map_or(0, |run| run.width);
        let range = |k: usize| {
            let column = runs.iter().flat_map(|run| run.inputs.iter().skip(k).step_by(width).copied());
            let edge = quantiles(column.collect(), &[0.01, 0.99]);
            (edge[0], edge[1])
        };
        Self((0..width).map(range).collect())
    }

    fn hold(&self, row: &[f64]) -> bool {
        row.iter().zip(&self.0).all(|(u, (low, high))| (low..=high).contains(&u))
    }
}

/// RMSE on runs, far unit, of the samples inside of the ranges alone. Where these are few, the ranges
/// themselves differ, and all samples count.
pub(super) fn error_inside(estimator: &Estimator, ranges: &Ranges, runs: &[&Run]) -> f64 {
    let masked: Vec<Run> = runs
        .iter()
        .map(|run| {
            let weight = |i: usize| if ranges.hold(run.row(i)) { run.weight[i] } else { 0.0 };
            Run { weight: (0..run.len()).map(weight).collect(), ..Run::clone(run) }
        })
        .collect();
    let masked: Vec<&Run> = masked.iter().collect();
    let sum = |runs: &[&Run]| runs.iter().flat_map(|run| &run.weight).sum::<f64>();
    rmse(estimator, if sum(&masked) < OVERLAP * sum(runs) { runs } else { &masked })
}
