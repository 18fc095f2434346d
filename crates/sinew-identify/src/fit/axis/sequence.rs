//! The columns of the runs that an axis is fitted to, and its error on them.

use crate::fit::run::Run;
use sinew::predictor::{Axis, Estimator, Memory, MemoryLaw, Signal};

/// Columns of one run.
pub(super) struct Sequence<'a> {
    pub(super) dt_s: &'a [f64],
    /// `[signals][n]`.
    pub(super) signals: Vec<Vec<f64>>,
    pub(super) far: &'a [f64],
    pub(super) weight: &'a [f64],
}

impl<'a> Sequence<'a> {
    pub(super) fn new(law: &MemoryLaw, run: &'a Run) -> Self {
        let column =
            |signal: &Signal| -> Vec<f64> { (0..run.len()).map(|i| signal.value(run.row(i))).collect() };
        let signals = law.signals.iter().map(column).collect();
        Self { dt_s: &run.dt_s, signals, far: &run.far, weight: &run.weight }
    }
}

/// Median of the sampling intervals.
pub(super) fn interval_s(sequences: &[Sequence<'_>]) -> Option<f64> {
    let mut all: Vec<f64> = sequences.iter().flat_map(|s| s.dt_s).copied().filter(|dt| *dt > 0.0).collect();
    let middle = all.len().checked_div(2).filter(|_| !all.is_empty())?;
    Some(*all.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Sum of squared errors of a law without networks, as at run time, over the rows that count.
pub(super) fn causal_squares(signals: &MemoryLaw, runs: &[&Run], axis: &Axis) -> f64 {
    let law = MemoryLaw { axis: Some(axis.clone()), features: Vec::new(), ..signals.clone() };
    let estimator = Estimator::of(law);
    let mut memory = Memory::new(&estimator.law);
    let mut sum = 0.0;
    for run in runs {
        memory.reset();
        for i in 0..run.len() {
            memory.step(&estimator.law, run.dt_s[i], run.row(i));
            let error = memory.cell().state - run.far[i];
            sum += run.weight[i] * error * error;
        }
    }
    if sum.is_finite() { sum } else { f64::INFINITY }
}
