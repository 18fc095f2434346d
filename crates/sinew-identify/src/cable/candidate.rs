//! The cable observer fitted to conditioned sequences, as a candidate of the comparison.

use super::fit::FitOptions;
use super::initial::identify_cable;
use super::log::CableLog;
use super::warming::fit_warming;
use super::weakening::fit_weakening;
use crate::fit::cell::START_PRIOR_SEQUENCES;
use crate::fit::run::Run;
use sinew::predictor::{CableColumns, CableModel, ObservedCable};

/// Shortest interval between the samples that are fitted, s: the law does not care, and the fit is as much
/// faster.
const INTERVAL_S: f64 = 4e-3;

/// Fits a cable to runs whose far side is in units of `newtons`; `None` where they do not show one.
pub(crate) fn fit_observed(runs: &[&Run], columns: CableColumns, newtons: f64) -> Option<ObservedCable> {
    let logs: Vec<CableLog> = runs.iter().map(|run| thinned(run, &columns, newtons)).collect();
    let fit = fit_weakening(&logs, identify_cable(&logs, &FitOptions::default()).ok()?);
    let mut model = fit_warming(&logs, fit.model);
    model.start = start_position(&model, &logs)?;
    model.far_gain /= newtons;
    Some(ObservedCable { model, columns })
}

/// Where in their dead band the logs begin, on average; the middle counts as [`START_PRIOR_SEQUENCES`] more
/// logs.
fn start_position(model: &CableModel, logs: &[CableLog]) -> Option<f64> {
    let whole = model.law().ok()?.friction_angle();
    let (mut sum, mut count) = (0.0, START_PRIOR_SEQUENCES);
    for log in logs.iter().filter(|log| !log.is_empty() && log.weight[0] > 0.0) {
        let far = log.far[0] / model.far_gain - model.parameters.pretension;
        let fraction = (log.samples[0].tension_in / far).ln() / whole;
        if fraction.is_finite() {
            sum += fraction.clamp(-1.0, 1.0);
            count += 1.0;
        }
    }
    Some(sum / count)
}

fn thinned(run: &Run, columns: &CableColumns, newtons: f64) -> CableLog {
    let mut log = CableLog::default();
    let mut since = 0.0;
    for row in 0..run.len() {
        since += run.dt_s[row];
        if row > 0 && since < INTERVAL_S {
            continue;
        }
        let far = if run.weight[row] > 0.0 { newtons * run.far[row] } else { f64::NAN };
        log.push(if row == 0 { 0.0 } else { since }, columns.sample(run.row(row)), far);
        since = 0.0;
    }
    log
}
