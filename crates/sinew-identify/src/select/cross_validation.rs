//! Cross-validation: every candidate is fitted without each fold and compared with what was held out.

use super::candidates::{CandidateRecipe, screening_recipe};
use super::folds::Folds;
use crate::conditioning::ConditionedLogs;
use crate::estimation::estimate_sequence;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::training::fit;
use rayon::prelude::*;
use sinew::metrics::Comparison;
use sinew::predictor::{Estimate, Estimator, MemoryLaw};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Makes a model from runs.
pub(crate) type Fit<'a> = dyn Fn(&[&Run]) -> Option<Estimator> + Sync + 'a;

/// Errors of one model on the data held out by one fold.
#[derive(Debug, Clone, Default)]
pub(crate) struct FoldScore {
    /// Index of the fold in [`Folds::held_out`].
    pub(crate) fold: usize,
    /// Samples that counted.
    pub(crate) samples: f64,
    /// Root mean square error over them.
    pub(crate) rmse: f64,
    /// Root mean square error of every sequence: two models are compared pair by pair.
    pub(crate) sequence_rmse: Vec<f64>,
    /// Quantiles of |error| / standard deviation at 0, 1/200, ... 1: folds of any length count alike.
    pub(crate) ratios: Vec<f64>,
}

/// How one model predicts data it was not fitted to.
#[derive(Debug, Clone)]
pub(crate) struct CrossValidation {
    /// Out-of-fold outputs, `[sequence][row]`; `None` where no fold held the row out.
    pub(crate) outputs: Vec<Vec<Option<(Estimate, usize)>>>,
    /// Folds in which a sample counted.
    pub(crate) folds: Vec<FoldScore>,
    /// `[fold]`: factor of the band on that fold, by the other folds.
    pub(crate) band_factors: Vec<f64>,
    /// All folds together.
    pub(crate) comparison: Comparison,
    /// Mean over the folds of the RMSE on the data each was fitted to.
    pub(crate) rmse_in_sample: f64,
    /// Physical laws fitted in each fold.
    pub(crate) laws: Vec<MemoryLaw>,
}

impl CrossValidation {
    /// Geometric mean of the RMSEs of all folds but `without`, by which candidates are ranked.
    pub(crate) fn score(&self, without: Option<usize>) -> f64 {
        let folds = self.folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
        let logarithms: Vec<f64> = folds.map(|(_, fold)| fold.rmse.max(1e-300).ln()).collect();
        (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
    }
}

/// A candidate with its cross-validation.
#[derive(Debug, Clone)]
pub(crate) struct ScoredCandidate {
    /// Short name.
    pub(crate) name: String,
    /// What it is, in a sentence.
    pub(crate) description: String,
    /// Its errors, or why it has none.
    pub(crate) outcome: Result<CrossValidation, String>,
}

impl ScoredCandidate {
    /// Its errors; `None` where it could not be fitted.
    pub(crate) fn validation(&self) -> Option<&CrossValidation> {
        self.outcome.as_ref().ok()
    }

    /// [`CrossValidation::score`]; infinite where it could not be fitted, or no fold is left.
    pub(crate) fn score(&self, without: Option<usize>) -> f64 {
        let score = self.validation().map_or(f64::INFINITY, |v| v.score(without));
        if score.is_nan() { f64::INFINITY } else { score }
    }
}

/// Cross-validates the screening recipe of every candidate; `finished` is called with the share that is done.
pub(crate) fn cross_validate_all(
    candidates: &[CandidateRecipe],
    logs: &ConditionedLogs,
    folds: &Folds,
    seed: u64,
    finished: &(dyn Fn(f64) + Sync),
) -> Vec<ScoredCandidate> {
    let done = AtomicUsize::new(0);
    let score = |candidate: &CandidateRecipe| {
        let recipe = screening_recipe(&candidate.recipe);
        let outcome = cross_validate(&|training| fit(&recipe, training, seed), &logs.runs, folds);
        finished((1 + done.fetch_add(1, Ordering::Relaxed)) as f64 / candidates.len() as f64);
        let (name, description) = (recipe.name, candidate.description.clone());
        ScoredCandidate { name, description, outcome }
    };
    candidates.par_iter().map(score).collect()
}

/// Fits without each fold and predicts what was held out; where that fails, the reason in words.
pub(crate) fn cross_validate(fit: &Fit<'_>, runs: &[Run], folds: &Folds) -> Result<CrossValidation, String> {
    let mut validation = CrossValidation {
        outputs: runs.iter().map(|run| vec![None; run.len()]).collect(),
        folds: Vec::new(),
        band_factors: Vec::new(),
        comparison: Comparison::new(),
        rmse_in_sample: 0.0,
        laws: Vec::new(),
    };
    for (fold, held_out) in folds.held_out.iter().enumerate() {
        let training = training_runs(runs, held_out);
        let of = folds.held_out.len();
        let estimator = fit(&training.iter().collect::<Vec<&Run>>())
            .ok_or_else(|| format!("the data without fold {} of {of} do not determine it", fold + 1))?;
        validation.rmse_in_sample += estimator.sigma0 / folds.held_out.len() as f64;
        validation.laws.push(estimator.law.clone());
        let score = validation
            .score_fold(fold, &estimator, runs, held_out)
            .ok_or_else(|| format!("its prediction of fold {} of {of} is not finite", fold + 1))?;
        validation.folds.extend(score);
    }
    let factor = |fold| band_factor(&validation.folds, Some(fold));
    validation.band_factors = (0..folds.held_out.len()).map(factor).collect();
    if validation.folds.is_empty() { Err("no held-out sample counts".to_owned()) } else { Ok(validation) }
}

impl CrossValidation {
    /// Predicts the rows that a fold held out; `Some(None)` where none of them counts, `None` for an estimate
    /// that is not finite.
    fn score_fold(
        &mut self,
        fold: usize,
        estimator: &Estimator,
        runs: &[Run],
        held_out: &[Option<(usize, usize)>],
    ) -> Option<Option<FoldScore>> {
        let mut ratios = Vec::new();
        let mut sequence_rmse = Vec::new();
        let (mut sum, mut count) = (0.0, 0.0);
        for (index, (run, range)) in runs.iter().zip(held_out).enumerate() {
            let Some((from, to)) = *range else { continue };
            let before = (sum, count);
            let outputs = estimate_sequence(estimator, run).into_iter().enumerate();
            for (row, output) in outputs.filter(|(row, _)| (from..to).contains(row)) {
                self.outputs[index][row] = Some((output, fold));
                if run.weight[row] > 0.0 {
                    let error = output.mean - run.far[row];
                    sum += error * error;
                    count += 1.0;
                    ratios.push(error.abs() / output.variance.sqrt().max(1e-300));
                    self.comparison.push(run.far[row], output.mean).ok()?;
                }
            }
            if count > before.1 {
                sequence_rmse.push(f64::sqrt((sum - before.0) / (count - before.1)));
            }
        }
        if count <= 0.0 {
            return Some(None);
        }
        let grid: Vec<f64> = (0..=200).map(|k| f64::from(k) / 200.0).collect();
        let ratios = quantiles(ratios, &grid);
        Some(Some(FoldScore { fold, samples: count, rmse: (sum / count).sqrt(), sequence_rmse, ratios }))
    }
}

/// Runs of one fold with the held-out rows at weight zero; runs without weight are left out.
fn training_runs(runs: &[Run], held_out: &[Option<(usize, usize)>]) -> Vec<Run> {
    runs.iter()
        .zip(held_out)
        .filter_map(|(run, range)| {
            let mut run = run.clone();
            if let Some((from, to)) = *range {
                let to = to.min(run.weight.len());
                run.weight[from..to].fill(0.0);
            }
            run.weight.iter().any(|w| *w > 0.0).then_some(run)
        })
        .collect()
}

/// Factor from standard deviation to half width of the 95 % band, by all folds but `without`.
///
/// ```text
/// c = (n + 1)/n Q(0.95 + 0.05/n),      Q: quantile of |error| / sigma over n folds of equal weight
/// ```
///
/// The level is that of split conformal prediction with `n` exchangeable folds: with one fold the largest ratio,
/// with many the 95 % quantile. The factor allows for a next log that differs from the folds more than they do
/// from each other.
pub(crate) fn band_factor(folds: &[FoldScore], without: Option<usize>) -> f64 {
    let kept = || folds.iter().filter(|fold| Some(fold.fold) != without || folds.len() == 1);
    let n = kept().count().max(1) as f64;
    let ratios: Vec<f64> = kept().flat_map(|fold| fold.ratios.iter().copied()).collect();
    (quantiles(ratios, &[0.95 + 0.05 / n])[0] * (n + 1.0) / n).max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_of_few_folds_is_stretched_most() {
        let fold = |fold: usize| FoldScore {
            fold,
            ratios: (0..=200).map(|k| f64::from(k) / 100.0).collect(),
            ..FoldScore::default()
        };
        let factor = |count: usize| band_factor(&(0..count).map(fold).collect::<Vec<_>>(), None);
        assert!((factor(1) - 2.0 * 2.0).abs() < 1e-9, "twice the largest ratio");
        assert!((factor(5) - 1.2 * 1.92).abs() < 0.02 && (factor(50) - 1.02 * 1.9).abs() < 0.02);
        let mut folds: Vec<FoldScore> = (0..3).map(fold).collect();
        folds[1].ratios.iter_mut().for_each(|ratio| *ratio *= 10.0);
        assert!(band_factor(&folds, Some(1)) <= 3.0 && band_factor(&folds, None) > 15.0);
        assert!(band_factor(&[], None) > 0.0);
    }
}
