//! The whole identification: logs in, a model and its honest account out.

use crate::Error;
use crate::account::Account;
use crate::account::build::{self, Found};
use crate::log::Dataset;
use crate::member::{Member, Recipe, Run, fit, quantiles};
use crate::runs;
use crate::select::folds::Folds;
use crate::select::influence;
use crate::select::judge::{Judgement, judge};
use crate::select::zoo::{Entry, zoo};
use rayon::prelude::*;
use sinew::predictor::{Estimator, Model, Provenance};

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
    pub account: Account,
}

/// A pure network must beat the physics by this factor on unseen data to be believed.
const PURE_MARGIN: f64 = 0.97;

/// Identifies the transmission behind a dataset.
///
/// # Errors
/// [`Error::Samples`] where a wanted member does not exist or nothing could be fitted.
pub fn identify(data: &Dataset, options: &Options, progress: &Progress<'_>) -> Result<Identification, Error> {
    let guards = runs::guards(data);
    let gap_s = runs::gap_s(data);
    let all_runs = runs::runs(data, &guards, gap_s);
    let entries = wanted(zoo(data, &all_runs), &options.models)?;

    progress("looking for foreign logs", 0.05);
    let (keep, influence) = influence::check(data, &all_runs, &influence_recipe(data, &all_runs));
    let data = &without(data, &keep);
    let runs = runs::runs(data, &guards, gap_s);

    let folds = Folds::of(data);
    let finished = std::sync::atomic::AtomicUsize::new(0);
    let judgements: Vec<Option<Judgement>> = entries
        .par_iter()
        .map(|entry| {
            let judgement = judge(&entry.recipe, &runs, &folds, options.seed);
            let done = 1 + finished.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            progress(
                "judging models on data they do not see",
                0.1 + 0.7 * done as f64 / entries.len() as f64,
            );
            judgement
        })
        .collect();
    let chosen = choose(&entries, &judgements, &folds)
        .ok_or_else(|| Error::samples("models", "one that can be fitted to these logs", &"none"))?;

    progress("fitting the chosen model to everything", 0.85);
    let references: Vec<&Run> = runs.iter().filter(|r| r.weight.iter().any(|w| *w > 0.0)).collect();
    let member = fit(&entries[chosen].recipe, &references, options.seed).ok_or_else(|| {
        Error::samples("model", "one that can be fitted to all logs", &entries[chosen].recipe.name)
    })?;
    let Some(judgement) = &judgements[chosen] else {
        return Err(Error::samples("model", "a judgement", &"none"));
    };
    let band_factor = judgement.fold_factor.iter().copied().fold(0.0, f64::max).max(1e-6);
    let model = Model {
        far: data.roles.far.clone().unwrap_or_default(),
        inputs: data.roles.inputs.clone(),
        time: data.roles.time.clone(),
        trial: data.roles.trial.clone(),
        guards,
        gap_s,
        estimator: estimator(&member),
        band_factor,
        provenance: Provenance {
            member: entries[chosen].recipe.name.clone(),
            description: entries[chosen].description.clone(),
            program: env!("CARGO_PKG_VERSION").to_string(),
            seed: options.seed,
            logs: data.logs.iter().map(|l| l.name.clone()).collect(),
            samples: runs.iter().map(Run::len).sum(),
            rmse_unseen: judgement.comparison.rmse().unwrap_or(f64::MAX),
            far_range: far_range(&runs),
        },
    };
    model.validate()?;
    progress("writing the account", 0.95);
    let found = Found {
        data,
        runs: &runs,
        entries: &entries,
        judgements: &judgements,
        chosen,
        model: &model,
        folds: &folds,
    };
    let account = build::account(&found, influence);
    Ok(Identification { model, account })
}

/// A quick hybrid: the cell alone is too stiff to be spoiled visibly.
fn influence_recipe(data: &Dataset, runs: &[Run]) -> Recipe {
    let mut recipe = zoo(data, runs).swap_remove(1).recipe;
    recipe.rows = 1500;
    recipe.steps = 25;
    recipe.hidden = 4;
    recipe.networks = 4;
    recipe
}

fn wanted(entries: Vec<Entry>, names: &[String]) -> Result<Vec<Entry>, Error> {
    if names.is_empty() {
        return Ok(entries);
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

/// The best geometric mean over folds; physics where a pure network is not clearly better or folds are few.
fn choose(entries: &[Entry], judgements: &[Option<Judgement>], folds: &Folds) -> Option<usize> {
    let score = |k: usize| judgements[k].as_ref().map_or(f64::INFINITY, |j| j.score);
    let best = |pure: bool| {
        (0..entries.len())
            .filter(|&k| entries[k].pure == pure && score(k).is_finite())
            .min_by(|&a, &b| score(a).total_cmp(&score(b)))
    };
    match (best(false), best(true)) {
        (Some(physics), Some(pure)) => {
            let clear = folds.grouped && score(pure) < PURE_MARGIN * score(physics);
            Some(if clear { pure } else { physics })
        }
        (physics, pure) => physics.or(pure),
    }
}

fn estimator(member: &Member) -> Estimator {
    Estimator {
        law: member.law.clone(),
        ensemble: member.ensemble.clone(),
        gate_power: member.gate_power,
        sigma0: member.sigma0,
    }
}

fn far_range(runs: &[Run]) -> f64 {
    let values: Vec<f64> = runs
        .iter()
        .flat_map(|r| r.far.iter().zip(&r.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y))
        .collect();
    let edge = quantiles(values, &[0.0005, 0.9995]);
    edge[1] - edge[0]
}
