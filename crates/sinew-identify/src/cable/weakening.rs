//! How fast friction falls with speed, from logs.

use super::fit::{CableFit, FitOptions, fit_cable};
use super::log::{CableLog, coarse};
use super::quantity::{INITIAL_WEAKENING, Quantity};
use rayon::prelude::*;

/// Speeds, m/s, and lags, s, of the velocity weakening from which it is searched: a third and a tenth of the
/// initial speed, three and ten times its lag.
const STARTS: [[f64; 2]; 2] = [
    [INITIAL_WEAKENING.speed / 3.2, 3.2 * INITIAL_WEAKENING.lag],
    [INITIAL_WEAKENING.speed / 10.0, 10.0 * INITIAL_WEAKENING.lag],
];
/// Accepted steps of a search, at most: everything else begins near its optimum.
const STEPS: usize = 12;

/// The fit, continued with speed and lag of the velocity weakening free as well, if that is better: held,
/// they displace friction angle and drag, by up to a tenth and by a factor of three on simulated logs.
#[must_use]
pub fn fit_weakening(logs: &[CableLog], fit: CableFit) -> CableFit {
    let free = Quantity::ALL_OF_FRICTION.to_vec();
    let options = FitOptions { free, steps: STEPS, multistart: false, ..FitOptions::default() };
    let coarse = coarse(logs);
    let continued = STARTS.par_iter().filter_map(|[speed, lag]| {
        let mut start = fit.model.clone();
        let weakening = start.parameters.weakening.as_mut()?;
        (weakening.speed, weakening.lag) = (*speed, *lag);
        fit_cable(&coarse, &start, &options).ok()
    });
    let best = continued.min_by(|a, b| a.rmse.total_cmp(&b.rmse));
    let best = best.and_then(|best| fit_cable(logs, &best.model, &options).ok());
    best.filter(|best| best.rmse < fit.rmse).unwrap_or(fit)
}
