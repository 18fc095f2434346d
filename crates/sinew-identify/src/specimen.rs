//! What the loops of one specimen look like on the near side, so that another one is noticed.

use crate::conditioning::ConditionedLogs;
use crate::fit::linear_algebra::{Cholesky, Matrix};
use crate::fit::statistics::{mean_and_deviation, quantiles, student};
use crate::log::Role;
use crate::select::folds::Folds;
use sinew::predictor::{LoopCheck, LoopQuantity, LoopState, LoopTerm, Loops, SpecimenMonitor};

/// Motion back from an extreme that counts as a reversal, over the range of the motion.
const REVERSAL: f64 = 0.1;

/// Trials beyond the terms of a regression below which its deviation is not known.
const FREEDOM: usize = 6;

/// Ridge over the variance of a standardised term.
const RIDGE: f64 = 1e-3;

/// Deviation of a term over its size below which it was held constant: what it does is not known.
const CONSTANT: f64 = 0.02;

/// Deviation of the level between trials, over the range of the effort, above which it is a load that is
/// varied.
const VARIED: f64 = 0.05;

/// Deviation of a quantity over its size that no sensor is better than.
const LEAST_DEVIATION: f64 = 2e-3;

/// The loops of one trial: their means, each alone, and the inputs at the last.
struct Trial {
    loops: Loops,
    each: Vec<Loops>,
    inputs: Vec<f64>,
    run: usize,
}

/// The monitor of the specimen of these logs; a reason in words where they do not show what it looks like,
/// which completes "because".
pub(crate) fn monitor(logs: &ConditionedLogs, folds: &Folds) -> Result<SpecimenMonitor, String> {
    let inputs = &logs.data.roles.inputs;
    let first = |role: Role| inputs.iter().position(|input| input.role == role);
    let (Some(effort), Some(motion)) = (first(Role::Effort), first(Role::Motion)) else {
        return Err("that takes a near effort and a near motion".to_owned());
    };
    let range = |input: usize| logs.limits[input].high - logs.limits[input].low;
    let reversal = REVERSAL * range(motion);
    if reversal <= 0.0 {
        return Err(format!("`{}` does not move", inputs[motion].column));
    }
    let trials = trials(logs, effort, motion, reversal);
    let given = (0..inputs.len()).filter(|&i| inputs[i].role == Role::Given).map(LoopTerm::Given);
    let context: Vec<LoopTerm> = [LoopTerm::Speed, LoopTerm::Stroke].into_iter().chain(given).collect();
    let of_loop = [LoopTerm::Level, LoopTerm::LevelSquared];
    let all: Vec<LoopTerm> = of_loop.into_iter().chain(context.iter().copied()).collect();
    let needed = all.len() + 1 + FREEDOM;
    if trials.len() < needed {
        let (found, name) = (trials.len(), &inputs[motion].column);
        return Err(format!(
            "that takes {needed} trials with three reversals of `{name}`, and {found} have them"
        ));
    }
    let levels: Vec<f64> = trials.iter().map(|trial| trial.loops.level).collect();
    let held = mean_and_deviation(&levels).1 < VARIED * range(effort);
    let mut quantities = vec![(LoopQuantity::Height, &all), (LoopQuantity::Slope, &all)];
    quantities.extend(held.then_some((LoopQuantity::Level, &context)));
    let check = |(quantity, terms): (LoopQuantity, &Vec<LoopTerm>)| {
        let kept: Vec<&Trial> = trials.iter().collect();
        let mut check = fit(quantity, terms, &kept, range(effort))?;
        let mut unseen = unseen(quantity, terms, &trials, folds, range(effort));
        if !unseen.is_empty() {
            unseen = quantiles(unseen, &[0.98]);
            check.limit = check.limit.max(unseen[0]);
        }
        let sizes: Vec<f64> = trials.iter().map(|trial| trial.loops.quantity(quantity).abs()).collect();
        let size = if quantity == LoopQuantity::Level { range(effort) } else { quantiles(sizes, &[0.5])[0] };
        (check.limit * check.deviation < size).then_some(check)
    };
    let checks: Vec<LoopCheck> = quantities.into_iter().filter_map(check).collect();
    if checks.is_empty() {
        return Err(format!("the loops of `{}` vary too much from trial to trial", inputs[effort].column));
    }
    Ok(SpecimenMonitor { effort, motion, reversal, checks })
}

fn trials(logs: &ConditionedLogs, effort: usize, motion: usize, reversal: f64) -> Vec<Trial> {
    let mut trials = Vec::new();
    for (run, rows) in logs.runs.iter().enumerate() {
        let (mut state, mut each, mut inputs) = (LoopState::default(), Vec::new(), Vec::new());
        for i in 0..rows.len() {
            let row = rows.row(i);
            if state.step(reversal, rows.dt_s[i], row[motion], row[effort]) {
                each.push(*state.latest());
                inputs = row.to_vec();
            }
        }
        if !each.is_empty() {
            trials.push(Trial { loops: *state.loops(), each, inputs, run });
        }
    }
    trials
}

/// The regression of a quantity over trials; none where it is singular.
fn fit(
    quantity: LoopQuantity,
    terms: &[LoopTerm],
    trials: &[&Trial],
    effort_range: f64,
) -> Option<LoopCheck> {
    let (n, width) = (trials.len(), terms.len());
    let value = |trial: &Trial, term: LoopTerm| trial.loops.term(term, &trial.inputs);
    let (mut mean, mut inverse_scale) = (Vec::new(), Vec::new());
    for &term in terms {
        let values: Vec<f64> = trials.iter().map(|trial| value(trial, term)).collect();
        let (middle, deviation) = mean_and_deviation(&values);
        let size = match term {
            LoopTerm::Level => effort_range,
            LoopTerm::LevelSquared => effort_range * effort_range,
            _ => middle.abs(),
        };
        mean.push(middle);
        inverse_scale.push(1.0 / deviation.max(CONSTANT * size).max(1e-12));
    }
    let row = |trial: &Trial| -> Vec<f64> {
        (0..width).map(|i| (value(trial, terms[i]) - mean[i]) * inverse_scale[i]).collect()
    };
    let rows: Vec<Vec<f64>> = trials.iter().map(|trial| row(trial)).collect();
    let far: Vec<f64> = trials.iter().map(|trial| trial.loops.quantity(quantity)).collect();
    let offset = far.iter().sum::<f64>() / n as f64;
    let normal = Matrix::from_fn(width, |i, j| {
        let ridge = if i == j { RIDGE * n as f64 } else { 0.0 };
        rows.iter().map(|x| x[i] * x[j]).sum::<f64>() + ridge
    });
    let factor = Cholesky::new(normal)?;
    let right: Vec<f64> =
        (0..width).map(|i| rows.iter().zip(&far).map(|(x, y)| x[i] * (y - offset)).sum()).collect();
    let weights = factor.solve(&right)?;
    let mut covariance = Vec::with_capacity(width * width);
    for i in 0..width {
        let unit: Vec<f64> = (0..width).map(|j| f64::from(u8::from(i == j))).collect();
        covariance.extend(factor.solve(&unit)?);
    }
    let predicted = |x: &Vec<f64>| offset + x.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>();
    let squares: f64 = rows.iter().zip(&far).map(|(x, y)| (y - predicted(x)).powi(2)).sum();
    let freedom = n.checked_sub(width + 1).filter(|freedom| *freedom > 0)?;
    let size = if quantity == LoopQuantity::Slope { quantiles(far, &[0.5])[0].abs() } else { effort_range };
    let scattered = trials.iter().map(|trial| {
        let each: Vec<f64> = trial.each.iter().map(|one| one.quantity(quantity)).collect();
        mean_and_deviation(&each).1.powi(2)
    });
    let scatter = quantiles(scattered.collect(), &[0.5])[0];
    Some(LoopCheck {
        quantity,
        terms: terms.to_vec(),
        mean,
        inverse_scale,
        offset,
        weights,
        covariance,
        trials: n,
        deviation: (squares / freedom as f64).sqrt().max(LEAST_DEVIATION * size).max(1e-12),
        scatter,
        limit: student(ONE_OF_A_THOUSAND, freedom),
    })
}

/// Sizes of `z` of the trials that each fold of whole trials held out.
fn unseen(
    quantity: LoopQuantity,
    terms: &[LoopTerm],
    trials: &[Trial],
    folds: &Folds,
    range: f64,
) -> Vec<f64> {
    let mut found = Vec::new();
    for held_out in folds.held_out.iter().filter(|_| folds.grouped) {
        let (out, kept): (Vec<&Trial>, Vec<&Trial>) =
            trials.iter().partition(|trial| held_out[trial.run].is_some());
        if kept.len() < terms.len() + 1 + FREEDOM {
            continue;
        }
        let check = fit(quantity, terms, &kept, range);
        found.extend(
            check.iter().flat_map(|check| {
                out.iter().map(|trial| check.deviation(&trial.loops, &trial.inputs).1.abs())
            }),
        );
    }
    found
}

/// Normal quantile that one of a thousand exceeds on either side.
const ONE_OF_A_THOUSAND: f64 = 3.2905;
