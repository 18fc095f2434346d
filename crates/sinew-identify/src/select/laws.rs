//! The classical laws on the folds of the candidates.

use super::cross_validation::{CrossValidation, ScoredCandidate, Stretch};
use super::folds::Folds;
use crate::conditioning::ConditionedLogs;
use crate::fit::classical::{ClassicalFit, LawPrediction, predict_classical};
use crate::log::Dataset;
use rayon::prelude::*;
use sinew::predictor::Estimate;

/// A classical law with its errors on held-out data and its fit without each fold.
pub(crate) struct ScoredLaw {
    pub(crate) scored: ScoredCandidate,
    /// `[fold]`.
    pub(crate) fits: Vec<ClassicalFit>,
}

/// Cross-validates every classical law as the candidates are, but for the direction of sliding, which the
/// laws take from the whole log.
pub(crate) fn cross_validate_laws(logs: &ConditionedLogs, folds: &Folds) -> Vec<ScoredLaw> {
    let of_fold = |fold: usize| predict_classical(&without(&logs.data, &folds.held_out[fold]));
    let mut fitted: Vec<Vec<LawPrediction>> =
        (0..folds.held_out.len()).into_par_iter().map(of_fold).collect();
    let names: Vec<(String, String)> = fitted
        .first()
        .iter()
        .flat_map(|laws| laws.iter())
        .map(|law| (law.fit.law.clone(), law.fit.equation.clone()))
        .collect();
    let one = |(name, description): (String, String)| {
        let take = |laws: &mut Vec<LawPrediction>| {
            let place = laws.iter().position(|law| law.fit.law == name)?;
            Some(laws.swap_remove(place))
        };
        let of_folds: Vec<Option<LawPrediction>> = fitted.iter_mut().map(take).collect();
        let outcome = validation(&of_folds, logs, folds);
        let fits = of_folds.into_iter().flatten().map(|law| law.fit).collect();
        ScoredLaw { scored: ScoredCandidate { name, description, outcome }, fits }
    };
    names.into_iter().map(one).collect()
}

/// The dataset without the far side of what a fold holds out.
fn without(data: &Dataset, held_out: &[Option<(usize, usize)>]) -> Dataset {
    let mut data = data.clone();
    for (sequence, range) in data.sequences.iter_mut().zip(held_out) {
        if let Some((from, to)) = *range {
            let to = to.min(sequence.far_clean.len());
            sequence.far_clean[from..to].fill(f64::NAN);
            sequence.scored[from..to].fill(false);
        }
    }
    data
}

fn validation(
    laws: &[Option<LawPrediction>],
    logs: &ConditionedLogs,
    folds: &Folds,
) -> Result<CrossValidation, String> {
    let of = folds.held_out.len();
    let mut validation = CrossValidation::default();
    for (fold, law) in laws.iter().enumerate() {
        let law = law
            .as_ref()
            .ok_or_else(|| format!("the data without fold {} of {of} do not determine it", fold + 1))?;
        validation.size = law.size;
        let estimate = |mean: &f64| Estimate {
            mean: *mean,
            variance: law.fit.rmse * law.fit.rmse,
            gate: 1.0,
            known: true,
            clipped: 0,
            beyond: 0.0,
        };
        let held = folds.held_out[fold].iter().enumerate();
        let stretch = |(sequence, range): (usize, &Option<(usize, usize)>)| {
            let (from, to) = (*range)?;
            let estimates = law.rows[sequence].iter().take(to).skip(from).map(estimate).collect();
            Some(Stretch { sequence, from, estimates })
        };
        validation.push(law.fit.rmse, held.filter_map(stretch).collect(), &logs.runs, of)?;
    }
    validation.concluded(of)
}
