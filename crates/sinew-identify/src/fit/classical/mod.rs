//! Classical laws fitted to a log: what each explains, with intervals, and what the data cannot tell.
//!
//! They are not candidates for prediction but the yardstick beside them, in parameters a person knows.
//!
//! * One near-side signal (the effort or motion that follows the far side best) is transmitted; one drive
//!   (the motion, or that signal itself) says which way and how far the cable has slid.
//! * Directions and speeds are taken with hindsight (a reversal counts from the extreme on), so the laws
//!   without memory show what they could do at best.
//! * States are reset at every sequence, starting from the measured far side. Rows that are not scored are
//!   stepped and not fitted; a missing near-side value is the one before it.
//! * Long logs are thinned to about 6000 rows for the fit, keeping 50 rows between reversals where they
//!   have them; the RMSE is over all scored rows.
//! * Positive parameters are fitted as logarithms, from several starts, by Levenberg-Marquardt.
//! * Intervals are `+- 1.96` standard deviations from `s^2 tau (J^T J)^-1` (in the logarithm where that was
//!   fitted). `tau = 1 + 2 sum_k rho_k` is the autocorrelation time of the residuals, summed until
//!   `rho_k < 0.05`: a thousand samples of one slow mistake are one observation, not a thousand.
//!   They hold if the law's structure does; where the residuals are not noise the remark says so.

mod capstan;
mod law;
mod memory;
mod play;
mod result;
mod samples;
#[cfg(test)]
mod tests;

pub use result::{ClassicalFit, Parameter};

use crate::log::Dataset;
use rayon::prelude::*;

/// Fits every classical law for which the dataset has the signals.
///
/// Where nothing can be fitted (a constant near or far side, too few samples) a single entry without
/// parameters says why in its remark. The result does not depend on the order of logs or columns beyond rounding.
#[must_use]
pub fn fit_classical(data: &Dataset) -> Vec<ClassicalFit> {
    let (all, thinned, signals) = match samples::gather(data) {
        Ok(gathered) => gathered,
        Err(why) => return vec![law::not_fitted(&why)],
    };
    let mut laws = vec![play::play(&thinned, &signals)];
    if signals.near_is_effort {
        laws.push(capstan::fixed(&thinned, &signals));
        if signals.has_motion {
            laws.push(capstan::speed_dependent(&thinned, &signals));
        }
    }
    laws.extend(memory::laws(&thinned, &signals));
    laws.par_iter().filter_map(|law| law.fit(&thinned, &all, &signals)).collect()
}
