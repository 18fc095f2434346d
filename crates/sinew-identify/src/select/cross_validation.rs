//! Cross-validation: every candidate is fitted without each fold and compared with what was held out.

use super::candidates::{CandidateRecipe, screening_recipe};
use super::folds::Folds;
use crate::conditioning::ConditionedLogs;
use crate::estimation::{estimate_sequence, size};
use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::training::{fit_law, fit_on};
use rayon::prelude::*;
use sinew::metrics::Comparison;
use sinew::predictor::{Estimate, Estimator, MemoryLaw};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Makes a model of a fold from its runs.
pub(crate) type Fit<'a> = dyn Fn(usize, &[&Run]) -> Option<Estimator> + Sync + 'a;

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

/// Outputs over consecutive rows of a sequence.
#[derive(Debug, Clone)]
pub(crate) struct Stretch {
    pub(crate) sequence: usize,
    /// Their first row.
    pub(crate) from: usize,
    pub(crate) estimates: Vec<Estimate>,
}

/// How one model predicts data it was not fitted to.
#[derive(Debug, Clone, Default)]
pub(crate) struct CrossValidation {
    /// Out-of-fold outputs: `[fold][stretch that it held out]`.
    pub(crate) outputs: Vec<Vec<Stretch>>,
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
    /// `[fold]`: error on the data it was fitted to.
    pub(crate) sigma0: Vec<f64>,
    /// Numbers that were fitted in a fold.
    pub(crate) size: usize,
    /// Weights of the members of a mean; empty for a model of its own.
    pub(crate) weights: Vec<f64>,
}

impl CrossValidation {
    /// Geometric mean of the RMSEs of all folds but `without`, by which candidates are ranked.
    pub(crate) fn score(&self, without: Option<usize>) -> f64 {
        let folds = self.folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
        let logarithms: Vec<f64> = folds.map(|(_, fold)| fold.rmse.max(1e-300).ln()).collect();
        (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
    }

    /// Root mean square of the RMSEs of all folds but `without`: one good fold cannot make up for bad ones.
    pub(crate) fn root_mean_square(&self, without: Option<usize>) -> f64 {
        let folds = self.folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
        let squares: Vec<f64> = folds.map(|(_, fold)| fold.rmse * fold.rmse).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
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

    /// [`CrossValidation::root_mean_square`]; infinite where it could not be fitted, or no fold is left.
    pub(crate) fn root_mean_square(&self, without: Option<usize>) -> f64 {
        let error = self.validation().map_or(f64::INFINITY, |v| v.root_mean_square(without));
        if error.is_nan() { f64::INFINITY } else { error }
    }

    /// [`CrossValidation::score`]; infinite where it could not be fitted, or no fold is left.
    pub(crate) fn score(&self, without: Option<usize>) -> f64 {
        let score = self.validation().map_or(f64::INFINITY, |v| v.score(without));
        if score.is_nan() { f64::INFINITY } else { score }
    }
}

/// Cross-validates the screening recipe of every candidate; `finished` is called with the fraction that is
/// done. Candidates that differ in their networks alone share the law of each fold.
pub(crate) fn cross_validate_all(
    candidates: &[CandidateRecipe],
    logs: &ConditionedLogs,
    folds: &Folds,
    seed: u64,
    finished: &(dyn Fn(f64) + Sync),
) -> Vec<ScoredCandidate> {
    let recipes: Vec<Recipe> =
        candidates.iter().map(|candidate| screening_recipe(&candidate.recipe)).collect();
    let mut physics: Vec<&Recipe> = Vec::new();
    for recipe in &recipes {
        if !physics.iter().any(|known| known.shares_physics(recipe)) {
            physics.push(recipe);
        }
    }
    let (fold_count, done) = (folds.held_out.len(), AtomicUsize::new(0));
    let steps = fold_count * physics.len() + candidates.len();
    let advance = || finished((1 + done.fetch_add(1, Ordering::Relaxed)) as f64 / steps as f64);
    let fit_one = |k: usize| {
        let training = training_runs(&logs.runs, &folds.held_out[k % fold_count]);
        let law = fit_law(physics[k / fold_count], &training.iter().collect::<Vec<_>>());
        advance();
        law
    };
    let laws: Vec<_> = (0..fold_count * physics.len()).into_par_iter().map(fit_one).collect();
    let score = |(candidate, recipe): (&CandidateRecipe, &Recipe)| {
        let of_physics = physics.iter().position(|known| known.shares_physics(recipe)).unwrap_or_default();
        let laws = &laws[of_physics * fold_count..][..fold_count];
        let fit = |fold: usize, training: &[&Run]| fit_on(laws[fold].clone()?, recipe, training, seed);
        let outcome = if candidate.mean_of.is_empty() {
            cross_validate(&fit, &logs.runs, folds)
        } else {
            Err(String::new())
        };
        advance();
        ScoredCandidate { name: recipe.name.clone(), description: candidate.description.clone(), outcome }
    };
    candidates.par_iter().zip(&recipes).map(score).collect()
}

/// Fits without each fold and predicts what was held out; where that fails, the reason in words.
pub(crate) fn cross_validate(fit: &Fit<'_>, runs: &[Run], folds: &Folds) -> Result<CrossValidation, String> {
    let fit_fold = |fold: usize| {
        let training = training_runs(runs, &folds.held_out[fold]);
        let estimator = fit(fold, &training.iter().collect::<Vec<&Run>>())?;
        let outputs = predict_fold(&estimator, runs, &folds.held_out[fold]);
        Some((estimator, outputs))
    };
    let of = folds.held_out.len();
    let fitted: Vec<_> = (0..of).into_par_iter().map(fit_fold).collect();
    let mut validation = CrossValidation::default();
    for (fold, fitted) in fitted.into_iter().enumerate() {
        let (estimator, outputs) = fitted
            .ok_or_else(|| format!("the data without fold {} of {of} do not determine it", fold + 1))?;
        validation.size = size(&estimator);
        validation.laws.push(estimator.law);
        validation.push(estimator.sigma0, outputs, runs, of)?;
    }
    validation.concluded(of)
}

/// Predicts the rows that a fold held out.
fn predict_fold(estimator: &Estimator, runs: &[Run], held_out: &[Option<(usize, usize)>]) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    for (sequence, (run, range)) in runs.iter().zip(held_out).enumerate() {
        if let Some((from, to)) = *range {
            let all = estimate_sequence(estimator, run);
            let estimates = all.into_iter().take(to).skip(from).collect();
            stretches.push(Stretch { sequence, from, estimates });
        }
    }
    stretches
}

impl CrossValidation {
    /// Adds the next fold.
    pub(super) fn push(
        &mut self,
        sigma0: f64,
        outputs: Vec<Stretch>,
        runs: &[Run],
        of: usize,
    ) -> Result<(), String> {
        let fold = self.outputs.len();
        let score = self.score_fold(fold, &outputs, runs);
        let score =
            score.ok_or_else(|| format!("its prediction of fold {} of {of} is not finite", fold + 1))?;
        self.rmse_in_sample += sigma0 / of as f64;
        self.sigma0.push(sigma0);
        self.outputs.push(outputs);
        self.folds.extend(score);
        Ok(())
    }

    /// With the factors of its bands, after the last fold.
    pub(super) fn concluded(mut self, of: usize) -> Result<Self, String> {
        self.band_factors = (0..of).map(|fold| band_factor(&self.folds, Some(fold))).collect();
        if self.folds.is_empty() { Err("no held-out sample counts".to_owned()) } else { Ok(self) }
    }

    /// Scores what a fold held out; `Some(None)` where none of it counts, `None` for an estimate that is not
    /// finite.
    fn score_fold(&mut self, fold: usize, outputs: &[Stretch], runs: &[Run]) -> Option<Option<FoldScore>> {
        let mut ratios = Vec::new();
        let mut sequence_rmse = Vec::new();
        let (mut sum, mut count) = (0.0, 0.0);
        for Stretch { sequence, from, estimates } in outputs {
            let run = &runs[*sequence];
            let before = (sum, count);
            for (row, output) in (*from..).zip(estimates) {
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

    /// Every held-out row with its output and fold, fold by fold.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, usize, &Estimate, usize)> {
        self.outputs.iter().enumerate().flat_map(|(fold, stretches)| {
            stretches.iter().flat_map(move |stretch| {
                let rows = (stretch.from..).zip(&stretch.estimates);
                rows.map(move |(row, estimate)| (stretch.sequence, row, estimate, fold))
            })
        })
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
/// c = Q(L),   Q: quantile of |error| / sigma over n folds of equal weight
/// L: least level in [0.95, 1] for which the mean over folds f of the fraction of |error| / sigma below Q(L; all but f)
///    is 0.95; 1 where there is none
/// ```
///
/// `Q(L; all but f)` is the band of the other folds on one that did not calibrate it, as a next log does not.
/// Where the folds agree the level is 0.95; where one of them is unlike the others it rises until that one is
/// covered. A single fold says nothing of a next one: its factor is twice its largest ratio.
///
/// # Source
/// Conformal prediction with sequences as the exchangeable units: `vovk2005`, `lei2018`.
pub(crate) fn band_factor(folds: &[FoldScore], without: Option<usize>) -> f64 {
    let kept: Vec<&FoldScore> =
        folds.iter().filter(|fold| Some(fold.fold) != without || folds.len() == 1).collect();
    let single = if kept.len() == 1 { 2.0 } else { 1.0 };
    let all = sorted_ratios(&kept, None);
    (single * at_level(&all, level(&kept))).clamp(1e-6, WIDEST)
}

/// A fold whose logs never change their far side knows no spread, and ratios to it are of any size.
const WIDEST: f64 = 1e6;

/// Coverage that the band promises.
const COVERAGE: f64 = 0.95;

/// Steps in which the level rises from [`COVERAGE`] to 1.
const LEVELS: u32 = 20;

/// The level `L` of [`band_factor`].
fn level(folds: &[&FoldScore]) -> f64 {
    if folds.len() < 2 {
        return 1.0;
    }
    let others: Vec<Vec<f64>> = (0..folds.len()).map(|f| sorted_ratios(folds, Some(f))).collect();
    let covered = |level: f64| {
        let fraction = |(fold, others): (&&FoldScore, &Vec<f64>)| {
            let limit = at_level(others, level);
            fold.ratios.iter().filter(|ratio| **ratio <= limit).count() as f64 / fold.ratios.len() as f64
        };
        folds.iter().zip(&others).map(fraction).sum::<f64>() / folds.len() as f64
    };
    let levels = (0..LEVELS).map(|k| COVERAGE + (1.0 - COVERAGE) * f64::from(k) / f64::from(LEVELS));
    levels.into_iter().find(|level| covered(*level) >= COVERAGE).unwrap_or(1.0)
}

/// Ratios of all folds but the one at `without`, least first.
fn sorted_ratios(folds: &[&FoldScore], without: Option<usize>) -> Vec<f64> {
    let kept = folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
    let mut ratios: Vec<f64> = kept.flat_map(|(_, fold)| fold.ratios.iter().copied()).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    ratios
}

/// The quantile of sorted values; zero where there are none.
fn at_level(sorted: &[f64], level: f64) -> f64 {
    let last = sorted.len().saturating_sub(1) as f64;
    sorted.get((level * last).round() as usize).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fold(fold: usize, size: f64) -> FoldScore {
        let ratios = (0..=200).map(|k| size * f64::from(k) / 100.0).collect();
        FoldScore { fold, ratios, ..FoldScore::default() }
    }

    #[test]
    fn folds_that_agree_give_their_quantile_and_a_single_one_is_no_evidence() {
        let alike: Vec<FoldScore> = (0..5).map(|k| fold(k, 1.0)).collect();
        assert!((band_factor(&alike, None) - 1.9).abs() < 0.02);
        assert!((band_factor(&alike[..1], None) - 4.0).abs() < 0.02 && band_factor(&[], None) > 0.0);
        // Of a fit to a far side that never changes.
        assert!(band_factor(&[fold(0, 1e130), fold(1, 1.0)], None) <= WIDEST);
    }

    #[test]
    fn a_fold_unlike_the_others_is_covered_by_the_band_of_all_and_not_by_that_of_the_others() {
        let mut folds: Vec<FoldScore> = (0..4).map(|k| fold(k, 1.0)).collect();
        folds[1] = fold(1, 5.0);
        let covered = |factor: f64| folds[1].ratios.iter().filter(|r| **r <= factor).count();
        assert!(covered(band_factor(&folds, Some(1))) < 80);
        let factor = band_factor(&folds, None);
        assert!(covered(factor) > 190 && factor < 10.1, "{factor}");
    }

    #[test]
    fn the_band_covers_19_of_20_samples_of_a_next_log_drawn_like_the_folds() {
        // Sizes of errors that differ from log to log by a factor of up to two.
        let size = |k: usize| 1.0 + ((k as f64) * 0.618_034).fract();
        for count in [5, 8] {
            let mut covered = 0;
            for draw in 0..200 {
                let logs: Vec<FoldScore> = (0..=count).map(|k| fold(k, size(draw * 13 + k * 7))).collect();
                let factor = band_factor(&logs[..count], None);
                covered += logs[count].ratios.iter().filter(|r| **r <= factor).count();
            }
            let fraction = f64::from(u32::try_from(covered).unwrap()) / (200.0 * 201.0);
            assert!((0.92..0.98).contains(&fraction), "{count} folds: {fraction}");
        }
    }
}
