//! The choice among cross-validated candidates, and the error to expect of what was chosen.

use super::candidates::{CandidateRecipe, PhysicsPrior};
use super::cross_validation::{FoldScore, ScoredCandidate};

/// A candidate with less physics must have at most this fraction of the error of one with more.
const MARGIN: f64 = 0.97;

/// Standard errors of the mean log ratio of errors, sequence by sequence, by which it must be better.
const STANDARD_ERRORS: f64 = 1.0;

/// The candidate with the least geometric mean of its errors over all folds but `without`; one with less
/// physics only where it is clearly better, and the folds hold out whole logs, trials or conditions.
pub(crate) fn choose(
    candidates: &[CandidateRecipe],
    scored: &[ScoredCandidate],
    grouped: bool,
    without: Option<usize>,
) -> Option<usize> {
    let score = |k: usize| scored[k].score(without);
    let mut chosen = None;
    for prior in PhysicsPrior::ALL {
        let best = (0..candidates.len())
            .filter(|&k| candidates[k].prior == prior && score(k).is_finite())
            .min_by(|&a, &b| score(a).total_cmp(&score(b)));
        chosen = match (chosen, best) {
            (Some(old), Some(new)) => {
                let clear = grouped
                    && score(new) < MARGIN * score(old)
                    && clearly_better(&scored[new], &scored[old], without);
                Some(if clear { new } else { old })
            }
            (chosen, best) => chosen.or(best),
        };
    }
    chosen
}

/// Whether the error is smaller, sequence by sequence, by more than [`STANDARD_ERRORS`].
fn clearly_better(one: &ScoredCandidate, other: &ScoredCandidate, without: Option<usize>) -> bool {
    let (Some(one), Some(other)) = (&one.validation, &other.validation) else { return false };
    let errors = |folds: &[FoldScore]| -> Vec<f64> {
        let kept = folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
        kept.flat_map(|(_, fold)| fold.sequence_rmse.iter().copied()).collect()
    };
    let pairs = errors(&one.folds).into_iter().zip(errors(&other.folds));
    let ratios: Vec<f64> = pairs.map(|(a, b)| (a.max(1e-300) / b.max(1e-300)).ln()).collect();
    let n = ratios.len() as f64;
    if n < 3.0 {
        return false;
    }
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0);
    mean + STANDARD_ERRORS * (variance / n).sqrt() < 0.0
}

/// Root mean square error of the selection as a whole, by leave-one-fold-out selection.
///
/// ```text
/// k_f = the candidate chosen on all folds but f
/// E^2 = sum_f n_f e(k_f, f)^2 / sum_f n_f
/// ```
///
/// The errors of the final choice on the folds that chose it are the least of many, hence too small; here no
/// fold takes part in the choice that it scores, and no model is fitted again. With fewer than two folds: the
/// plain error.
pub(crate) fn selection_rmse(
    scored: &[ScoredCandidate],
    chosen: usize,
    choose: &dyn Fn(Option<usize>) -> Option<usize>,
) -> f64 {
    let folds = |k: usize| scored[k].validation.as_ref().map_or(&[][..], |v| v.folds.as_slice());
    let count = folds(chosen).len();
    let (mut sum, mut samples) = (0.0, 0.0);
    for fold in 0..count {
        let choice = if count > 1 { choose(Some(fold)) } else { None };
        let score = choice.and_then(|k| folds(k).get(fold)).unwrap_or(&folds(chosen)[fold]);
        sum += score.samples * score.rmse * score.rmse;
        samples += score.samples;
    }
    (sum / samples).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::select::cross_validation::CrossValidation;
    use sinew::metrics::Comparison;

    /// A candidate with one sequence of one sample in every fold.
    fn scored(fold_rmse: &[f64]) -> ScoredCandidate {
        let fold = |(fold, rmse): (usize, &f64)| FoldScore {
            fold,
            samples: 1.0,
            rmse: *rmse,
            sequence_rmse: vec![*rmse],
            band_factor: 1.0,
        };
        let validation = CrossValidation {
            outputs: vec![],
            folds: fold_rmse.iter().enumerate().map(fold).collect(),
            comparison: Comparison::new(),
            rmse_in_sample: 0.0,
            laws: vec![],
        };
        ScoredCandidate { name: String::new(), description: String::new(), validation: Some(validation) }
    }

    #[test]
    fn one_sequence_with_a_small_error_is_not_significant() {
        let physics = scored(&[3.4, 1.4, 1.4, 2.7]);
        let better = |one: &ScoredCandidate, other: &ScoredCandidate| clearly_better(one, other, None);
        assert!(!better(&scored(&[1.8, 1.5, 1.45, 2.8]), &physics));
        assert!(better(&scored(&[2.0, 1.1, 1.0, 1.9]), &physics));
        assert!(!better(&scored(&[1.0, 1.0]), &scored(&[2.0, 2.0])), "two are too few");
        assert!(!better(&physics, &physics));
    }

    #[test]
    fn the_error_of_a_selection_is_scored_on_folds_that_took_no_part_in_it() {
        // Each candidate has a small error on one fold by chance.
        let all = [scored(&[0.1, 1.0, 1.0]), scored(&[1.0, 0.2, 1.0]), scored(&[1.0, 1.0, 0.3])];
        let choose =
            |without| (0..3).min_by(|&a, &b| all[a].score(without).total_cmp(&all[b].score(without)));
        let chosen = choose(None).unwrap();
        assert_eq!(chosen, 0);
        // Without fold 0 candidate 1 is best, without another one candidate 0: each has error 1 on its fold.
        assert!((selection_rmse(&all, chosen, &choose) - 1.0).abs() < 1e-12);
        // A candidate that is best everywhere keeps its plain error.
        let all = [scored(&[0.5, 0.5, 0.5]), scored(&[1.0, 1.0, 1.0])];
        let choose =
            |without| (0..2).min_by(|&a, &b| all[a].score(without).total_cmp(&all[b].score(without)));
        assert!((selection_rmse(&all, 0, &choose) - 0.5).abs() < 1e-12);
    }
}
