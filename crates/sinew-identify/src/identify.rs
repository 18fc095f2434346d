//! The whole identification: logs in, a model and its honest account out.

use crate::Error;
use crate::conditioning;
use crate::fit::recipe::{Learner, Recipe};
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::log::Dataset;
use crate::report::build::{self, Found};
use crate::report::{IdentificationReport, InfluenceRow};
use crate::select::candidates::{CandidateRecipe, PhysicsPrior, candidates};
use crate::select::cross_validation::{ScoredCandidate, cross_validate};
use crate::select::folds::Folds;
use crate::select::influence;
use crate::training::fit;
use rayon::prelude::*;
use sinew::predictor::{Estimator, InputLimits, Model, Provenance};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the user may choose.
#[derive(Debug, Clone)]
pub struct Options {
    /// Seed of every random draw.
    pub seed: u64,
    /// Members to try; empty for all.
    pub models: Vec<String>,
}

/// Stages of an identification, for a progress display.
pub type Progress<'a> = dyn Fn(&str, f64) + Sync + 'a;

/// A model with its account.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The chosen model, ready to run.
    pub model: Model,
    /// What was tried, how it did, what to do next.
    pub report: IdentificationReport,
}

/// What stands on less physics must beat what stands on more by this factor on unseen data to be believed.
const MARGIN: f64 = 0.97;

/// Standard errors by which it must do so, sequence by sequence: few sequences prove little.
const CHANCE: f64 = 1.0;

/// Identifies the transmission behind a dataset.
///
/// # Errors
/// [`Error::Samples`] where a wanted member does not exist or nothing could be fitted.
pub fn identify(data: &Dataset, options: &Options, progress: &Progress<'_>) -> Result<Identification, Error> {
    let guards = conditioning::guards(data);
    let gap_s = conditioning::gap_s(data);
    let all_runs = conditioning::condition(data, &guards, gap_s);
    let entries = wanted(candidates(data, &all_runs), &options.models)?;

    progress("looking for foreign logs", 0.05);
    let (keep, influence) = influence::check(data, &all_runs, &influence_recipe(data, &all_runs));
    let data = &without(data, &keep);
    let runs = conditioning::condition(data, &guards, gap_s);

    let folds = Folds::of(data);
    let finished = AtomicUsize::new(0);
    let tried: Vec<ScoredCandidate> = entries
        .par_iter()
        .map(|entry| {
            let recipe = screening_recipe(&entry.recipe);
            let validation = cross_validate(&|training| fit(&recipe, training, options.seed), &runs, &folds);
            let done = 1 + finished.fetch_add(1, Ordering::Relaxed);
            let done = 0.1 + 0.7 * done as f64 / entries.len() as f64;
            progress("judging models on data they do not see", done);
            ScoredCandidate {
                name: entry.recipe.name.clone(),
                description: entry.description.clone(),
                validation,
            }
        })
        .collect();
    let chosen = choose(&entries, &tried, &folds)
        .ok_or_else(|| Error::samples("models", "one that can be fitted to these logs", &"none"))?;

    progress("fitting the chosen model to everything", 0.85);
    let recipe = &entries[chosen].recipe;
    let estimator = fit(recipe, &counting(&runs), options.seed)
        .ok_or_else(|| Error::samples("model", "one that can be fitted to all logs", &recipe.name))?;
    progress("writing the account", 0.95);
    let work = Work { data, runs: &runs, folds: &folds, guards, gap_s, seed: options.seed };
    finish(&work, &tried, chosen, estimator, influence)
}

/// What an identification worked on.
pub(crate) struct Work<'a> {
    pub(crate) data: &'a Dataset,
    pub(crate) runs: &'a [Run],
    pub(crate) folds: &'a Folds,
    pub(crate) guards: Vec<InputLimits>,
    pub(crate) gap_s: f64,
    pub(crate) seed: u64,
}

/// Runs with a sample that counts.
pub(crate) fn counting(runs: &[Run]) -> Vec<&Run> {
    runs.iter().filter(|r| r.weight.iter().any(|w| *w > 0.0)).collect()
}

/// Model and account of the chosen estimator.
pub(crate) fn finish(
    work: &Work<'_>,
    tried: &[ScoredCandidate],
    chosen: usize,
    estimator: Estimator,
    influence: Vec<InfluenceRow>,
) -> Result<Identification, Error> {
    let Work { data, runs, folds, .. } = *work;
    let Some(validation) = &tried[chosen].validation else {
        return Err(Error::samples("model", "a validation", &"none"));
    };
    let model = Model {
        far: data.roles.far.clone().unwrap_or_default(),
        inputs: data.roles.inputs.clone(),
        time: data.roles.time.clone(),
        trial: data.roles.trial.clone(),
        guards: work.guards.clone(),
        gap_s: work.gap_s,
        estimator,
        band_factor: band_factor(&validation.fold_factor),
        provenance: Provenance {
            member: tried[chosen].name.clone(),
            description: tried[chosen].description.clone(),
            program: env!("CARGO_PKG_VERSION").to_string(),
            seed: work.seed,
            logs: data.logs.iter().map(|l| l.name.clone()).collect(),
            samples: runs.iter().map(Run::len).sum(),
            rmse_unseen: validation.comparison.rmse().unwrap_or(f64::MAX),
            far_range: far_range(runs),
        },
    };
    model.validate()?;
    let found = Found { data, runs, tried, chosen, model: &model, folds };
    let report = build::report(&found, influence);
    Ok(Identification { model, report })
}

/// Largest factor that any fold asked for, stretched as the largest of `n` draws must be to reach what the next
/// may ask for: by `(n + 1) / n`. Two days say less about a third than five do.
fn band_factor(of_folds: &[f64]) -> f64 {
    let n = of_folds.len().max(1) as f64;
    (of_folds.iter().copied().fold(0.0, f64::max) * (n + 1.0) / n).max(1e-6)
}

/// A recipe as it is compared: half the networks, trained for half as long, rank recipes as the whole would.
fn screening_recipe(recipe: &Recipe) -> Recipe {
    if recipe.learner == Learner::Paper {
        return Recipe { rows: 10_000, steps: 40, ..recipe.clone() };
    }
    Recipe { rows: 3000, steps: 25, networks: 4, ..recipe.clone() }
}

/// A quick hybrid: the cell alone is too stiff to be spoiled visibly.
fn influence_recipe(data: &Dataset, runs: &[Run]) -> Recipe {
    let mut recipe = candidates(data, runs).swap_remove(2).recipe;
    recipe.rows = 1500;
    recipe.steps = 25;
    recipe.hidden = 4;
    recipe.networks = 4;
    recipe
}

fn wanted(entries: Vec<CandidateRecipe>, names: &[String]) -> Result<Vec<CandidateRecipe>, Error> {
    if names.is_empty() {
        // Turns are tried where they are asked for: better on one rig, worse on another, and the folds cannot tell.
        return Ok(entries.into_iter().filter(|entry| entry.recipe.rounds == 0).collect());
    }
    let known: Vec<String> = entries.iter().map(|e| e.recipe.name.clone()).collect();
    for name in names {
        if !known.contains(name) {
            return Err(Error::samples("--model", format!("auto or one of {}", known.join(", ")), name));
        }
    }
    Ok(entries.into_iter().filter(|e| names.contains(&e.recipe.name)).collect())
}

fn without(data: &Dataset, keep: &[bool]) -> Dataset {
    let mut data = data.clone();
    let mut place = vec![0; keep.len()];
    let mut next = 0;
    for (k, kept) in keep.iter().enumerate() {
        place[k] = next;
        next += usize::from(*kept);
    }
    data.sequences.retain(|s| keep[s.log]);
    data.sequences.iter_mut().for_each(|s| s.log = place[s.log]);
    let mut index = 0;
    data.logs.retain(|_| {
        index += 1;
        keep[index - 1]
    });
    data
}

/// The best geometric mean over folds; what stands on less physics must be clearly better.
fn choose(entries: &[CandidateRecipe], tried: &[ScoredCandidate], folds: &Folds) -> Option<usize> {
    let score = |k: usize| tried[k].score();
    let mut chosen = None;
    for prior in PhysicsPrior::ALL {
        let best = (0..entries.len())
            .filter(|&k| entries[k].prior == prior && score(k).is_finite())
            .min_by(|&a, &b| score(a).total_cmp(&score(b)));
        chosen = match (chosen, best) {
            (Some(old), Some(new)) => {
                let clear = folds.grouped
                    && score(new) < MARGIN * score(old)
                    && clearly_better(&tried[new], &tried[old]);
                Some(if clear { new } else { old })
            }
            (chosen, best) => chosen.or(best),
        };
    }
    chosen
}

/// Whether the error is smaller sequence by sequence, beyond the chance of these few.
fn clearly_better(one: &ScoredCandidate, other: &ScoredCandidate) -> bool {
    let (Some(one), Some(other)) = (&one.validation, &other.validation) else { return false };
    let pairs = one.sequence_rmse.iter().zip(&other.sequence_rmse);
    let ratios: Vec<f64> = pairs.map(|(a, b)| (a.max(1e-300) / b.max(1e-300)).ln()).collect();
    let n = ratios.len() as f64;
    if n < 3.0 {
        return false;
    }
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0);
    mean + CHANCE * (variance / n).sqrt() < 0.0
}

fn far_range(runs: &[Run]) -> f64 {
    let values: Vec<f64> = runs
        .iter()
        .flat_map(|r| r.far.iter().zip(&r.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y))
        .collect();
    let edge = quantiles(values, &[0.0005, 0.9995]);
    edge[1] - edge[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::select::cross_validation::CrossValidation;
    use sinew::metrics::Comparison;

    fn tried(sequence_rmse: &[f64]) -> ScoredCandidate {
        let validation = CrossValidation {
            outputs: vec![],
            fold_rmse: sequence_rmse.to_vec(),
            sequence_rmse: sequence_rmse.to_vec(),
            fold_factor: vec![],
            comparison: Comparison::new(),
            rmse_in_sample: 0.0,
            laws: vec![],
            score: 0.0,
        };
        ScoredCandidate { name: String::new(), description: String::new(), validation: Some(validation) }
    }

    #[test]
    fn one_lucky_sequence_proves_nothing() {
        let physics = tried(&[3.4, 1.4, 1.4, 2.7]);
        assert!(!clearly_better(&tried(&[1.8, 1.5, 1.45, 2.8]), &physics));
        assert!(clearly_better(&tried(&[2.0, 1.1, 1.0, 1.9]), &physics));
        assert!(!clearly_better(&tried(&[1.0, 1.0]), &tried(&[2.0, 2.0])), "two are too few to tell");
        assert!(!clearly_better(&physics, &physics));
    }

    #[test]
    fn the_band_of_few_folds_is_stretched_most() {
        assert!((band_factor(&[2.0, 1.0]) - 3.0).abs() < 1e-12);
        assert!((band_factor(&[2.0, 1.0, 1.5, 1.2, 1.9]) - 2.4).abs() < 1e-12);
        assert!(band_factor(&[]) > 0.0);
    }
}
