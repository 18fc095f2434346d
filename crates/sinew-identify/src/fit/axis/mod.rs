//! Fit of an axis: a moving mass between the two sides, as force from motion or as motion from force.
//!
//! Inertia, friction and spring are identified from rates without lag: measured columns are differentiated by
//! central differences, and both sides of the equation pass the same filter, forwards and backwards, which
//! leaves the equation as it was (`gautier1997`). At run time the rates are causal; how much of the past they
//! use is chosen by the error of the causal prediction.

mod force;
mod motion;
mod plan;
mod sequence;
mod zero_phase;

pub(crate) use plan::{AxisKind, AxisPlan, FittedAxis};

use super::run::Run;
use sequence::{Sequence, interval_s};
use sinew::predictor::MemoryLaw;

/// Fits an axis to runs with these signals; `None` where they hold too little to fit.
pub(crate) fn fit_axis(signals: &MemoryLaw, runs: &[&Run], plan: &AxisPlan) -> Option<FittedAxis> {
    let sequences: Vec<Sequence> = runs.iter().map(|run| Sequence::new(signals, run)).collect();
    let interval_s = interval_s(&sequences)?;
    match plan.kind {
        AxisKind::Force => force::fit(signals, runs, &sequences, plan, interval_s),
        AxisKind::Motion => motion::fit(&sequences, plan, interval_s),
    }
}

#[cfg(test)]
mod tests;
