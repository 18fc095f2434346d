//! Adaptation: a short calibration of another specimen, with the old model as prior.
//!
//! Five variants are cross-validated on the calibration log, and the best is chosen:
//!
//! | name      | what it changes                                                                         |
//! |-----------|-----------------------------------------------------------------------------------------|
//! | unchanged | nothing                                                                                 |
//! | scaled    | gain and offset of the old prediction                                                   |
//! | corrected | gain and offset, then a regression on stops and loop coordinates of what is left        |
//! | transfer  | gain and offset, then the networks with their old weights as prior mean (the default)   |
//! | fresh     | everything but the structure                                                            |

use crate::Error;
use crate::calibration::calibrate;
use crate::conditioning::{ConditionedLogs, gap_s, input_limits};
use crate::estimation::{estimate_sequence, rmse};
use crate::fit::cell::CellPlan;
use crate::fit::ensemble::{self, Rows};
use crate::fit::recipe::{FeaturePlan, Learner, Recipe};
use crate::fit::run::Run;
use crate::identify::{Identification, Options, Progress};
use crate::log::Dataset;
use crate::report::Evidence;
use crate::report::build::report;
use crate::select::candidates::LOOP_RADII;
use crate::select::choice::selection_rmse;
use crate::select::cross_validation::{ScoredCandidate, cross_validate};
use crate::select::folds::Folds;
use crate::select::laws::cross_validate_laws;
use crate::specimen::monitor;
use crate::training::{features_of, fit_cell_of, fit_networks};
use rayon::prelude::*;
use sinew::predictor::{Estimator, Feature, InputLimits, MEMBERS, Member, MemoryLaw, Model, Role, Signal};
use sinew::transmission::{BasisTerm, ClampCell};

/// Another variant is chosen only where its error is below this fraction of the transfer's.
const MARGIN: f64 = 0.95;

/// Most rows the networks are trained on.
const ROWS: usize = 5000;

/// Makes a model from runs.
type Variant<'a> = dyn Fn(&[&Run]) -> Option<Estimator> + Sync + 'a;

/// Adapts `old` to the specimen of `data`, which was read with the columns of `old`.
///
/// # Errors
/// [`Error::NothingFitted`] where no variant could be fitted.
pub fn adapt(
    old: &Model,
    data: &Dataset,
    options: &Options,
    progress: &Progress<'_>,
) -> Result<Identification, Error> {
    let limits = union(&old.guards, &input_limits(data));
    let logs = ConditionedLogs::with_limits(data.clone(), limits, old.gap_s.max(gap_s(data)));
    let folds = Folds::new(data);
    let prior = &old.estimator;
    let fresh = |training: &[&Run]| fresh(prior, training, options.seed);
    let strength = correction_strength(old, &logs, &folds);
    let correct = |training: &[&Run]| corrected(old, training, strength?);
    let variants: [(&str, &str, &Variant<'_>); 5] = [
        ("unchanged", "the old model as it was", &|training| Some(remeasured(prior.clone(), training))),
        ("scaled", "the old model with a new gain and offset", &|training| scaled(prior, training)),
        ("corrected", "the old model plus a regression on stops and loops of the near side", &correct),
        (
            "transfer",
            "the old model as prior: what the calibration does not determine stays as it was",
            &|training| transfer(prior, training),
        ),
        ("fresh", "the structure of the old model, fitted anew", &fresh),
    ];
    let mut scored = Vec::new();
    for (k, (name, description, fit)) in variants.iter().enumerate() {
        progress("cross-validating the adaptations", 0.1 + 0.15 * k as f64);
        let outcome = cross_validate(&|_, training| fit(training), &logs.runs, &folds);
        scored.push(ScoredCandidate { name: (*name).into(), description: (*description).into(), outcome });
    }
    let choose = |without| choose(&scored, without);
    let chosen = choose(None).ok_or(Error::NothingFitted { what: "any adaptation" })?;
    let rmse = selection_rmse(&scored, chosen, &choose);
    let estimator =
        variants[chosen].2(&logs.counted()).ok_or(Error::NothingFitted { what: "the chosen adaptation" })?;
    let specimen = monitor(&logs, &folds);
    let model =
        calibrate(estimator, &scored[chosen], rmse, (&logs, &folds), specimen.as_ref().ok(), options.seed)?;
    let reason = format!(
        "{} was chosen: the smallest root mean square error over all folds, or the transfer where no \
            other is {:.0} % better.",
        scored[chosen].name,
        100.0 * (1.0 - MARGIN)
    );
    let evidence = Evidence {
        logs: &logs,
        scored: &scored,
        laws: &cross_validate_laws(&logs, &folds),
        chosen,
        not_compared: &[],
        reason,
        model: &model,
        folds: &folds,
        not_monitored: specimen.err(),
    };
    let report = report(&evidence, Vec::new());
    Ok(Identification { model, report })
}

/// The variant with the smallest root mean square error over all folds but `without`, because the few folds
/// of a calibration are unequal and a lucky one must not decide; the transfer unless another is clearly
/// better.
fn choose(scored: &[ScoredCandidate], without: Option<usize>) -> Option<usize> {
    let score = |k: usize| scored[k].root_mean_square(without);
    let best =
        (0..scored.len()).filter(|&k| score(k).is_finite()).min_by(|&a, &b| score(a).total_cmp(&score(b)))?;
    let transfer = scored.iter().position(|t| t.name == "transfer").filter(|&k| score(k).is_finite());
    Some(transfer.filter(|&k| score(best) > MARGIN * score(k)).unwrap_or(best))
}

/// Limits that allow what either allows.
fn union(old: &[InputLimits], new: &[InputLimits]) -> Vec<InputLimits> {
    let either = |(a, b): (&InputLimits, &InputLimits)| InputLimits {
        jump: a.jump.max(b.jump),
        low: a.low.min(b.low),
        high: a.high.max(b.high),
        typical: b.typical,
    };
    old.iter().zip(new).map(either).collect()
}

/// With the training error it has on these runs.
fn remeasured(mut estimator: Estimator, runs: &[&Run]) -> Estimator {
    estimator.sigma0 = rmse(&estimator, runs);
    estimator
}

/// A new gain and offset by least squares, drawn lightly to 1 and 0.
fn scaled(old: &Estimator, runs: &[&Run]) -> Option<Estimator> {
    let (mut n, mut sx, mut sy) = (0.0, 0.0, 0.0);
    let mut pairs = Vec::new();
    for sequence in runs {
        for ((estimate, far), weight) in
            estimate_sequence(old, sequence).iter().zip(&sequence.far).zip(&sequence.weight)
        {
            if *weight > 0.0 {
                pairs.push((estimate.mean, *far));
                (n, sx, sy) = (n + 1.0, sx + estimate.mean, sy + far);
            }
        }
    }
    let (mx, my) = (sx / n, sy / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in &pairs {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
    }
    let ridge = 1e-3 * xx;
    let gain = (xy + ridge) / (xx + ridge);
    let sound = gain.is_finite() && gain > 0.0 && n > 1.0;
    sound.then(|| remeasured(affine(old, gain, my - gain * mx), runs))
}

/// The same estimator with `gain y + offset` in place of `y`, `gain > 0`.
fn affine(old: &Estimator, gain: f64, offset: f64) -> Estimator {
    let mut new = old.clone();
    let own =
        old.linear.is_some() || old.ensemble.is_some() || old.perceptron.is_some() || old.law.has_physics();
    let all: f64 = old.members.iter().map(|member| member.weight).sum();
    for Member { estimator, .. } in &mut new.members {
        *estimator = affine(estimator, gain, if own { 0.0 } else { offset / all });
    }
    let is_cell = new.law.cell.is_some() || new.law.axis.is_some() || new.linear.is_some();
    if let Some(linear) = &mut new.linear {
        let here = old.law.cell.is_none() && old.law.axis.is_none();
        linear.weights.iter_mut().for_each(|weight| *weight *= gain);
        linear.offset = gain * linear.offset + if here { offset } else { 0.0 };
    }
    new.law.axis = new.law.axis.map(|axis| axis.rescaled(gain, offset));
    if let Some(cell) = &mut new.law.cell {
        affine_cell(cell, gain, offset);
    }
    if let Some(ensemble) = &mut new.ensemble {
        let factor = gain as f32;
        for lanes in ensemble.output_weights.iter_mut().chain(&mut ensemble.skip).chain([&mut ensemble.bias])
        {
            lanes.iter_mut().for_each(|v| *v *= factor);
        }
        if !is_cell {
            ensemble.bias.iter_mut().for_each(|v| *v += offset as f32);
        }
        // The cell's own features change their unit with it.
        for (i, feature) in new.law.features.iter().enumerate() {
            let shift = match feature {
                Feature::CellState => offset,
                Feature::CellWidth => 0.0,
                _ => continue,
            };
            for value in [&mut ensemble.mean[i], &mut ensemble.clip_low[i], &mut ensemble.clip_high[i]] {
                *value = *value * gain + shift;
            }
            ensemble.inverse_scale[i] /= gain;
        }
    }
    new.gate_power = new.gate_power.map(|p| p * gain * gain);
    new
}

fn affine_cell(cell: &mut ClampCell, gain: f64, offset: f64) {
    for (k, term) in cell.basis.iter().enumerate() {
        let shift = if matches!(term, BasisTerm::One) { offset } else { 0.0 };
        cell.low[k] = cell.low[k] * gain + shift;
        cell.high[k] = cell.high[k] * gain + shift;
    }
    cell.kappa.iter_mut().for_each(|k| *k *= gain);
}

/// Gain and offset, then every network trained on from what it was.
fn transfer(old: &Estimator, runs: &[&Run]) -> Option<Estimator> {
    if !old.members.is_empty() {
        return of_members(old, runs, &|member| transfer(member, runs).or_else(|| scaled(member, runs)));
    }
    let mut new = scaled(old, runs)?;
    let Some(ensemble) = &new.ensemble else { return None };
    let mut rows = Rows::collect(&new.law, runs, ROWS);
    new.linear.iter().for_each(|linear| rows.subtract(linear));
    let trained = ensemble::retrain(&rows, ensemble)?;
    if new.gate_power.is_some() {
        new.gate_power = Some(ensemble::mean_square_correction(&trained, &rows));
    }
    new.ensemble = Some(trained);
    Some(remeasured(new, runs))
}

/// A mean of members adapted one by one; `None` for more than a mean.
fn of_members(
    old: &Estimator,
    runs: &[&Run],
    adapted: &(dyn Fn(&Estimator) -> Option<Estimator> + Sync),
) -> Option<Estimator> {
    if old.linear.is_some() || old.ensemble.is_some() || old.law.has_physics() {
        return None;
    }
    let one = |member: &Member| Some(Member { estimator: adapted(&member.estimator)?, ..member.clone() });
    let members = old.members.par_iter().map(one).collect::<Option<Vec<_>>>()?;
    Some(remeasured(Estimator { members, ..old.clone() }, runs))
}

/// Ridges of a [`corrected`] model, relative to the variance of a feature.
const STRENGTHS: [f64; 4] = [5e-4, 5e-3, 5e-2, 0.5];

/// The ridge with the smallest root mean square error over the folds.
fn correction_strength(old: &Model, logs: &ConditionedLogs, folds: &Folds) -> Option<f64> {
    let error = |strength: f64| {
        let fit = |_: usize, training: &[&Run]| corrected(old, training, strength);
        let validation = cross_validate(&fit, &logs.runs, folds).ok()?;
        Some((strength, validation.root_mean_square(None)))
    };
    let errors = STRENGTHS.into_iter().filter_map(error);
    errors.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(strength, _)| strength)
}

/// The old model with gain and offset, plus a regression of what it leaves on stops and loop coordinates of
/// efforts and motions. `None` for a cable's observer.
fn corrected(old: &Model, runs: &[&Run], strength: f64) -> Option<Estimator> {
    if old.estimator.law.cable.is_some() {
        return None;
    }
    let estimator = scaled(&old.estimator, runs)?;
    let near = old.inputs.iter().enumerate().filter(|(_, input)| input.role != Role::Given);
    let signals: Vec<Signal> = near.map(|(input, _)| Signal::Input(input)).collect();
    let all: Vec<usize> = (0..signals.len()).collect();
    let plan = FeaturePlan {
        signals: all.clone(),
        radii: LOOP_RADII.to_vec(),
        loops: all,
        ..FeaturePlan::default()
    };
    let mut law = MemoryLaw { signals, cell: None, cable: None, axis: None, features: Vec::new() };
    law.features = features_of(&plan, &law, runs)?;
    let residual = |run: &&Run| {
        let outputs = estimate_sequence(&estimator, run);
        let far = run.far.iter().zip(&outputs).map(|(far, output)| far - output.mean).collect();
        Run { far, ..Run::clone(run) }
    };
    let residuals: Vec<Run> = runs.iter().map(residual).collect();
    let rows = Rows::collect(&law, &residuals.iter().collect::<Vec<_>>(), ROWS);
    let linear = ensemble::train_law(&rows, strength)?;
    let members = vec![Member { weight: 1.0, inside: false, estimator }];
    Some(remeasured(Estimator { linear: Some(linear), members, ..Estimator::of(law) }, runs))
}

/// The structure of the old model fitted anew.
fn fresh(old: &Estimator, runs: &[&Run], seed: u64) -> Option<Estimator> {
    if !old.members.is_empty() {
        return of_members(old, runs, &|member| fresh(member, runs, seed));
    }
    let mut law = old.law.clone();
    if let Some(cell) = &old.law.cell {
        let branches = cell.branches.iter().map(|b| b.width).collect();
        let (basis, elastic) = (cell.basis.clone(), cell.elastic.clone());
        let plan = CellPlan { basis, elastic, branches, effects: Vec::new(), released: false };
        law.cell = Some(fit_cell_of(&law, &plan, runs)?);
    }
    let ensemble = old.ensemble.as_ref();
    let hidden = ensemble.map(|e| e.hidden_bias.len()).or(old.perceptron.as_ref().map(|p| p.hidden()));
    let learner = match (&old.linear, &old.perceptron) {
        (Some(_), _) if ensemble.is_some() => Learner::Skeleton,
        (Some(_), _) => Learner::Regression,
        (None, Some(_)) => Learner::Paper,
        (None, None) => Learner::Ensemble,
    };
    let plan = FeaturePlan::default();
    let recipe = Recipe {
        name: String::new(),
        signals: law.signals.clone(),
        cell: None,
        cable: None,
        axis: None,
        features: (hidden.is_some() || old.linear.is_some()).then_some(plan),
        hidden: hidden.unwrap_or(0),
        rows: ROWS,
        steps: 40,
        networks: MEMBERS,
        learner,
    };
    fit_networks(law, &recipe, runs, seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::select::cross_validation::{CrossValidation, FoldScore};

    fn scored(name: &str, errors: [f64; 3]) -> ScoredCandidate {
        let fold =
            |(fold, rmse): (usize, f64)| FoldScore { fold, samples: 1.0, rmse, ..FoldScore::default() };
        let folds = errors.into_iter().enumerate().map(fold).collect();
        let outcome = Ok(CrossValidation { folds, ..CrossValidation::default() });
        ScoredCandidate { name: name.into(), description: String::new(), outcome }
    }

    #[test]
    fn one_lucky_fold_does_not_choose_a_variant_that_is_bad_on_the_others() {
        let variants = [scored("transfer", [4.0, 4.0, 4.0]), scored("fresh", [0.1, 9.0, 9.0])];
        assert!(variants[1].score(None) < variants[0].score(None), "its geometric mean is smaller");
        assert_eq!(choose(&variants, None), Some(0));
        let better = [scored("transfer", [4.0, 4.0, 4.0]), scored("fresh", [3.0, 3.5, 3.5])];
        assert_eq!(choose(&better, None), Some(1));
    }
}
