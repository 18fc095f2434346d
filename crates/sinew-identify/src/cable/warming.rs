//! How fast the drag of a cable is adapted as it runs, from logs.

use super::log::{CableLog, observe_log};
use rayon::prelude::*;
use sinew::predictor::CableModel;

/// Gains of the adaptation that are tried, 1/(N m).
const GAINS: [f64; 6] = [0.03, 0.1, 0.2, 0.5, 1.0, 2.0];

/// Less than this of the error without an adaptation has to be left by one: what noise gains does not count.
const LEFT: f64 = 0.98;

/// The gain of a model's drag adaptation, 1/(N m), by which it follows the far side of the logs best; 0 where
/// no adaptation leaves 2 % less of the error, or where the model has no law.
///
/// For a model whose other numbers are fitted: grease warms as a cable slides, and a log of minutes shows it.
#[must_use]
pub fn fit_adaptation(logs: &[CableLog], model: &CableModel) -> f64 {
    let error = |learning: f64| far_squares(&CableModel { learning, ..model.clone() }, logs);
    let errors: Vec<(f64, f64)> = GAINS.par_iter().map(|gain| (*gain, error(*gain))).collect();
    let best = errors.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let worth = LEFT * LEFT * error(0.0);
    best.filter(|(_, error)| *error < worth).map_or(0.0, |(gain, _)| gain)
}

/// Mean square of the far side's error where the estimate is no guess, N^2; how many these are differs a
/// little between gains. Not finite where there is none.
fn far_squares(model: &CableModel, logs: &[CableLog]) -> f64 {
    let squares = |log: &CableLog| {
        let estimates = observe_log(model, log).ok()?;
        let far = log.far.iter().zip(&log.weight);
        let known =
            estimates.iter().zip(far).filter(|(estimate, (_, weight))| estimate.known && **weight > 0.0);
        Some(known.map(|(estimate, (far, _))| (estimate.far - far).powi(2)).collect::<Vec<_>>())
    };
    let squares: Option<Vec<Vec<f64>>> = logs.iter().map(squares).collect();
    squares.map_or(f64::INFINITY, |squares| {
        let all = squares.concat();
        all.iter().sum::<f64>() / all.len() as f64
    })
}
