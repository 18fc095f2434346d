//! How the drag of a cable falls as friction warms its grease, from logs.

use super::fit::{FitOptions, fit_cable_model};
use super::log::{CableLog, beginnings, observe_log, thinned};
use super::quantity::Quantity;
use rayon::prelude::*;
use sinew::predictor::CableModel;
use sinew::transmission::Warming;

/// Times in which the sheath cools that are tried, as parts of the longest log: with a longer one, drag would
/// fall in operation below what any log shows.
const TIMES: [f64; 3] = [0.1, 0.3, 1.0];
/// Softening at the end of the longest log from which a search starts, 1.
const START: f64 = 0.1;
/// What is fitted beside the rate.
const REFITTED: [Quantity; 4] =
    [Quantity::FrictionAngle, Quantity::Drag, Quantity::Pretension, Quantity::Rise];
/// Samples that are searched over, at most, from the beginnings of the logs.
const SAMPLES: usize = 160_000;
/// Accepted steps of a search, at most: everything else begins near its optimum.
const STEPS: usize = 12;
/// The same while it is found out whether there is anything to search for.
const FIRST_STEPS: usize = 3;
/// Less than this of the error has to be left: what noise gains does not count.
const LEFT: f64 = 0.98;

/// The model with the warming of its grease, and with friction, drag and pretension as they are beside it;
/// the model as it is where that does not leave 2 % less of the error of the far side.
///
/// For a model whose other numbers are fitted. Every log is taken to begin with cold grease.
#[must_use]
pub fn fit_warming(logs: &[CableLog], model: CableModel) -> CableModel {
    let logs = &beginnings(logs, SAMPLES);
    let longest = logs.iter().map(CableLog::seconds).fold(0.0, f64::max);
    let power = power(logs);
    if !(power > 0.0 && longest > 0.0) {
        return model;
    }
    let fitted = |logs: &[CableLog], steps: usize, model: &CableModel, warming: Option<Warming>| {
        let start = CableModel { warming, ..model.clone() };
        let mut free = REFITTED.to_vec();
        free.extend(warming.map(|_| Quantity::WarmingRate));
        let options =
            FitOptions { free, samples: usize::MAX, steps, multistart: false, ..FitOptions::default() };
        let model = fit_cable_model(logs, &start, &options).ok()?;
        Some((far_squares(&model, logs), model))
    };
    // What friction and drag gain by being fitted once more is not warmth.
    let cold = |logs: &[CableLog], steps: usize| {
        let fitted = fitted(logs, steps, &model, None).map_or(f64::INFINITY, |(squares, _)| squares);
        fitted.min(far_squares(&model, logs))
    };
    let thinned = thinned(logs);
    let warmed = TIMES.par_iter().filter_map(|part| {
        let time = (part * longest).max(1.0);
        fitted(&thinned, FIRST_STEPS, &model, Some(Warming { rate: (START / (power * time)).min(1.0), time }))
    });
    let best = warmed.min_by(|a, b| a.0.total_cmp(&b.0));
    // Half of what has to be gained is enough to look closer.
    let best = best.filter(|(squares, _)| *squares < LEFT * cold(&thinned, FIRST_STEPS));
    let best = best.and_then(|(_, best)| fitted(logs, STEPS, &best, best.warming));
    match best {
        Some((squares, warmed)) if squares < LEFT * LEFT * cold(logs, STEPS) => warmed,
        _ => model,
    }
}

/// Mean power of friction, W: what the ends' forces leave in the cable.
fn power(logs: &[CableLog]) -> f64 {
    let (mut work, mut seconds) = (0.0, 0.0);
    for log in logs {
        for row in 1..log.len() {
            let (a, b) = (&log.samples[row - 1], &log.samples[row]);
            let done = b.tension_in * (b.motor - a.motor) - log.far[row] * (b.anchor - a.anchor);
            if done.is_finite() && log.weight[row] > 0.0 {
                work += done;
                seconds += log.interval_s[row];
            }
        }
    }
    work / seconds
}

/// Mean square of the far side's error where the estimate is no guess, N^2. Not finite where there is none.
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
