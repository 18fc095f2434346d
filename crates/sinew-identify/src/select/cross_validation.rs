//! Out-of-fold validation of a model.

use super::folds::Folds;
use crate::fit::run::Run;
use crate::training::estimate_sequence;
use sinew::metrics::Comparison;
use sinew::predictor::{Estimate, Estimator, MemoryLaw};

/// Makes a model from runs.
pub(crate) type Fit<'a> = dyn Fn(&[&Run]) -> Option<Estimator> + Sync + 'a;

/// How one model did on data it had not seen.
#[derive(Debug, Clone)]
pub(crate) struct CrossValidation {
    /// Out-of-fold outputs, `[sequence][row]`; `None` where no fold held the row out.
    pub(crate) outputs: Vec<Vec<Option<(Estimate, usize)>>>,
    /// RMSE per fold.
    pub(crate) fold_rmse: Vec<f64>,
    /// RMSE of every sequence in every fold that held it out: what two models are compared on pair by pair.
    pub(crate) sequence_rmse: Vec<f64>,
    /// 95 % quantile of |error| / sigma per fold.
    pub(crate) fold_factor: Vec<f64>,
    /// All folds together.
    pub(crate) comparison: Comparison,
    /// Mean over the folds of the RMSE on the data each was fitted to.
    pub(crate) rmse_in_sample: f64,
    /// What was fitted in each fold before its networks.
    pub(crate) laws: Vec<MemoryLaw>,
    /// Geometric mean of the fold RMSEs: what members are ranked by.
    pub(crate) score: f64,
}

/// Runs of one fold with the held-out rows at weight zero; runs without weight are left out.
pub(crate) fn training_runs(runs: &[Run], held_out: &[Option<(usize, usize)>]) -> Vec<Run> {
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

/// A model that was tried: what it is called and how it did.
#[derive(Debug, Clone)]
pub(crate) struct ScoredCandidate {
    /// Short name, as `--model` takes it.
    pub(crate) name: String,
    /// What it is, in a sentence.
    pub(crate) description: String,
    /// How it did; `None` where it could not be fitted.
    pub(crate) validation: Option<CrossValidation>,
}

impl ScoredCandidate {
    /// What models are ranked by; infinite where it could not be fitted.
    pub(crate) fn score(&self) -> f64 {
        self.validation.as_ref().map_or(f64::INFINITY, |j| j.score)
    }
}

/// Fits without each fold and predicts what was held out; `None` where a fit fails.
pub(crate) fn cross_validate(fit: &Fit<'_>, runs: &[Run], folds: &Folds) -> Option<CrossValidation> {
    let mut outputs: Vec<Vec<Option<(Estimate, usize)>>> = runs.iter().map(|r| vec![None; r.len()]).collect();
    let mut fold_rmse = Vec::new();
    let mut fold_factor = Vec::new();
    let mut sequence_rmse = Vec::new();
    let (mut rmse_in_sample, mut laws) = (0.0, Vec::new());
    let mut comparison = Comparison::new();
    for (fold, held_out) in folds.held_out.iter().enumerate() {
        let training = training_runs(runs, held_out);
        let references: Vec<&Run> = training.iter().collect();
        let member = fit(&references)?;
        rmse_in_sample += member.sigma0 / folds.held_out.len() as f64;
        laws.push(member.law.clone());
        let mut ratios = Vec::new();
        let (mut sum, mut count) = (0.0, 0.0);
        for (index, (run, range)) in runs.iter().zip(held_out).enumerate() {
            let Some((from, to)) = *range else { continue };
            let before = (sum, count);
            for (row, output) in estimate_sequence(&member, run).into_iter().enumerate() {
                if row < from || row >= to {
                    continue;
                }
                outputs[index][row] = Some((output, fold));
                if run.weight[row] > 0.0 {
                    let error = output.mean - run.far[row];
                    sum += error * error;
                    count += 1.0;
                    ratios.push(error.abs() / output.variance.sqrt().max(1e-300));
                    comparison.push(run.far[row], output.mean).ok()?;
                }
            }
            if count > before.1 {
                sequence_rmse.push(f64::sqrt((sum - before.0) / (count - before.1)));
            }
        }
        if count > 0.0 {
            fold_rmse.push((sum / count).sqrt());
            fold_factor.push(crate::fit::statistics::quantiles(ratios, &[0.95])[0]);
        }
    }
    if fold_rmse.is_empty() {
        return None;
    }
    let score = (fold_rmse.iter().map(|r| r.max(1e-300).ln()).sum::<f64>() / fold_rmse.len() as f64).exp();
    Some(CrossValidation {
        outputs,
        fold_rmse,
        sequence_rmse,
        fold_factor,
        comparison,
        rmse_in_sample,
        laws,
        score,
    })
}
