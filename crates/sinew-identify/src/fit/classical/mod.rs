//! Classical friction laws fitted to a log, with confidence intervals and identifiability.
//!
//! They are the reference beside the candidates, in physical parameters, and cross-validated as they are.
//!
//! * One near-side signal (the effort or motion that follows the far side best) is transmitted; one drive
//!   (the motion, or that signal itself) gives direction and distance of sliding. The capstan laws transmit
//!   the effort where it has the far side's unit.
//! * Directions and speeds are not causal (a reversal counts from the extreme on), which favours the laws
//!   without memory. These are fitted only where the cable slides for certain: near a reversal and at rest
//!   the direction is not known, and they are wrong by the whole friction where it is.
//! * States are reset at every sequence, starting from the measured far side, or where that is held out in
//!   the middle of their band. Rows that are not scored are stepped and not fitted; a missing near-side value
//!   is the one before it.
//! * Long logs are thinned to about 6000 rows for the fit, keeping 50 rows between reversals where they
//!   have them; the RMSE is over all scored rows.
//! * Positive parameters are fitted as logarithms, from several starts, by Levenberg-Marquardt.
//! * Intervals are `+- 1.96` standard deviations from `s^2 tau (J^T J)^-1` (in the logarithm where that was
//!   fitted). `tau = 1 + 2 sum_k rho_k` is the autocorrelation time of the residuals, summed until
//!   `rho_k < 0.05`. They hold if the structure of the law does; the remark names residuals that are not
//!   noise.

mod capstan;
mod law;
mod memory;
mod play;
mod result;
mod samples;

pub(crate) use law::{FRICTION_ANGLE, PRETENSION, STIFFNESS};
pub use result::{ClassicalFit, Parameter};

use crate::log::Dataset;
use law::{Fitted, Law};
use rayon::prelude::*;
use samples::{Samples, Signals};

/// Fits every classical law for which the dataset has the signals.
///
/// Where nothing can be fitted (a constant near or far side, too few samples) a single entry without
/// parameters gives the reason in its remark. The result does not depend on the order of logs or columns
/// beyond rounding.
#[must_use]
pub fn fit_classical(data: &Dataset) -> Vec<ClassicalFit> {
    match fit(data, None) {
        Ok((fits, _)) => fits.into_iter().map(|fitted| fitted.fit).collect(),
        Err(why) => vec![law::not_fitted(&why)],
    }
}

/// Fits one classical law by its [`ClassicalFit::law`], as [`fit_classical`] does, in a fraction of its time.
///
/// | near side | laws |
/// |---|---|
/// | tension | `capstan play`, `static capstan`, `capstan play with presliding`; with a motion `capstan with Stribeck, viscous growth and drag` |
/// | displacement | `backlash play` |
/// | either | `Dahl`, `Bouc-Wen`, `LuGre` (`LuGre under the near load`), `generalised Maxwell slip` |
///
/// # Errors
/// Why nothing can be fitted to the dataset; a name that is none of these, or whose law needs other signals.
pub fn fit_classical_law(data: &Dataset, name: &str) -> Result<ClassicalFit, String> {
    let none = || format!("no law `{name}` is fitted to these signals");
    fit(data, Some(name))?.0.pop().map(|fitted| fitted.fit).ok_or_else(none)
}

/// A law fitted to a part of a dataset, and what it predicts for all of it.
pub(crate) struct LawPrediction {
    pub(crate) fit: ClassicalFit,
    /// Numbers that were fitted.
    pub(crate) size: usize,
    /// `[sequence][row]`; empty where the near side of a sequence is missing.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// Fits every law to the rows of a dataset whose far side is there and counts, and predicts all rows.
pub(crate) fn predict_classical(data: &Dataset) -> Vec<LawPrediction> {
    let Ok((fits, all)) = fit(data, None) else { return Vec::new() };
    let rows = |predictions: &[f64]| {
        let mut rows = vec![Vec::new(); data.sequences.len()];
        for (run, &sequence) in all.runs.iter().zip(&all.sequences) {
            rows[sequence] = predictions[run.clone()].to_vec();
        }
        rows
    };
    let one = |Fitted { fit, size, predictions }| LawPrediction { fit, size, rows: rows(&predictions) };
    fits.into_iter().map(one).collect()
}

/// Fits the laws, or the one of the name `only`, and the samples that they predict; a reason where nothing
/// can be fitted.
fn fit(data: &Dataset, only: Option<&str>) -> Result<(Vec<Fitted>, Samples), String> {
    let (all, thinned, signals) = samples::gather(data)?;
    let mut fits = Vec::new();
    if !signals.near_is_effort && signals.effort_is_like_far {
        // A position follows the far side better; the capstan still makes one tension of the other.
        let ([all, thinned], signals) =
            ([&all, &thinned].map(Samples::with_effort_near), signals.with_effort_near());
        fits.extend(fit_all(&capstan_laws(&thinned, &signals), only, &thinned, &all, &signals));
    }
    let mut laws = if signals.near_is_effort {
        capstan_laws(&thinned, &signals)
    } else {
        vec![play::play(&thinned, &signals, false)]
    };
    laws.extend(memory::laws(&thinned, &signals, only));
    fits.extend(fit_all(&laws, only, &thinned, &all, &signals));
    Ok((fits, all))
}

/// Laws that make the far tension of the near one.
fn capstan_laws(thinned: &Samples, signals: &Signals) -> Vec<Law> {
    let mut laws = vec![
        play::play(thinned, signals, false),
        play::play(thinned, signals, true),
        capstan::fixed(thinned, signals),
    ];
    if signals.has_motion {
        laws.push(capstan::speed_dependent(thinned, signals));
    }
    laws
}

fn fit_all(
    laws: &[Law],
    only: Option<&str>,
    thinned: &Samples,
    all: &Samples,
    signals: &Signals,
) -> Vec<Fitted> {
    let requested = laws.par_iter().filter(|law| only.is_none_or(|only| law.name == only));
    requested.filter_map(|law| law.fit(thinned, all, signals)).collect()
}

#[cfg(test)]
mod tests {
    use super::predict_classical;
    use crate::log::{Dataset, Input, Role, Roles, Sequence};
    use std::collections::BTreeMap;

    /// A cable in a sheath, moved to and fro, whose friction grows with its speed; once it moves by
    /// `jump` metres in a fifth of a second.
    fn moved(log: usize, jump: f64, scored: bool) -> Sequence {
        let (interval, rate, speed) = (0.005, 2.0, 0.02);
        let time_s: Vec<f64> = (0..2000).map(|i| f64::from(i) * interval).collect();
        let near: Vec<f64> = time_s.iter().map(|t| 60.0 + 20.0 * (rate * t).sin()).collect();
        let far = time_s.iter().zip(&near).map(|(t, tension)| {
            let (v, noise) = (speed * (rate * t).cos(), 0.05 * (37.0 * t).sin());
            tension * (-v.signum() * (0.4 + 5.0 * v.abs())).exp() + noise
        });
        let far: Vec<f64> = far.collect();
        let at = |t: f64| speed / rate * (rate * t).sin() + jump * ((t - 5.2) / 0.2).clamp(0.0, 1.0);
        let inputs = time_s.iter().zip(&near).flat_map(|(t, tension)| [*tension, at(*t)]);
        Sequence {
            log,
            trial: String::new(),
            row: (0..time_s.len()).collect(),
            inputs: inputs.collect(),
            far_clean: far.clone(),
            far,
            scored: vec![scored; time_s.len()],
            condition_values: vec![],
            time_s,
        }
    }

    #[test]
    fn friction_that_grows_with_speed_stays_as_it_is_beyond_the_speeds_of_the_fit() {
        let columns = [("near_n", Role::Effort), ("near_m", Role::Motion)];
        let inputs = columns.map(|(column, role)| Input { column: column.to_owned(), role }).to_vec();
        let roles = Roles {
            far: Some("far_n".to_owned()),
            inputs,
            time: None,
            trial: None,
            group: None,
            units: BTreeMap::new(),
        };
        let sequences = vec![moved(0, 0.0, true), moved(1, -0.4, false)];
        let data = Dataset { roles, columns: vec![], logs: vec![], conditions: vec![], sequences };
        let laws = predict_classical(&data);
        let law = laws.iter().find(|law| law.fit.law.contains("viscous growth")).unwrap();
        let largest = law.rows[1].iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        assert!(largest < 200.0, "{largest}");
    }
}
