//! Means of candidates: their weights by what the folds held out, and their cross-validation.

use super::candidates::CandidateRecipe;
use super::cross_validation::{CrossValidation, ScoredCandidate, Stretch};
use super::folds::Folds;
use crate::conditioning::ConditionedLogs;
use crate::fit::linear_algebra::{Cholesky, Matrix};
use crate::fit::run::Run;
use crate::training::mean_of;
use rayon::prelude::*;
use sinew::predictor::{Estimator, MemoryLaw};

/// Part of the weight that is the same for every member: one that is seldom right still shows by its spread
/// where none is certain.
const EQUAL: f64 = 0.25;

/// Recordings from which on their errors say which member is right: few differ by offsets of their own.
const RECORDINGS: usize = 12;

/// Cross-validates the means among candidates, whose members are [`scored`](ScoredCandidate) already.
pub(crate) fn cross_validate_means(
    candidates: &[CandidateRecipe],
    scored: &[ScoredCandidate],
    logs: &ConditionedLogs,
    folds: &Folds,
) -> Vec<ScoredCandidate> {
    let mean = |(candidate, scored_candidate): (&CandidateRecipe, &ScoredCandidate)| {
        let mut found = scored_candidate.clone();
        if !candidate.mean_of.is_empty() {
            found.outcome = mean_outcome(candidate, scored, logs, folds);
        }
        found
    };
    candidates.par_iter().zip(scored).map(mean).collect()
}

/// The cross-validation of a mean of other candidates.
fn mean_outcome(
    candidate: &CandidateRecipe,
    scored: &[ScoredCandidate],
    logs: &ConditionedLogs,
    folds: &Folds,
) -> Result<CrossValidation, String> {
    let member = |(name, inside): &(String, bool)| {
        let found = scored.iter().find(|scored| scored.name == *name).and_then(ScoredCandidate::validation);
        found
            .map(|validation| (validation, *inside))
            .ok_or_else(|| format!("its member {name} could not be fitted"))
    };
    let members = candidate.mean_of.iter().map(member).collect::<Result<Vec<_>, _>>()?;
    mean_validation(&members, &logs.runs, folds)
}

/// The cross-validation of a mean, from those of its members, which were fitted to the same folds; of each
/// whether it counts inside the training data alone.
fn mean_validation(
    members: &[(&CrossValidation, bool)],
    runs: &[Run],
    folds: &Folds,
) -> Result<CrossValidation, String> {
    let of = folds.held_out.len();
    let Some((first, _)) = members.first() else { return Err("it has no members".to_owned()) };
    let size = members.iter().map(|(member, _)| member.size).sum();
    let (laws, all) = (first.laws.clone(), weights(members, runs, None));
    let mut validation = CrossValidation { laws, size, weights: all, ..CrossValidation::default() };
    for fold in 0..of {
        let stub = |(member, inside): &(&CrossValidation, bool)| {
            let law = MemoryLaw { signals: vec![], cell: None, cable: None, axis: None, features: vec![] };
            (Estimator { sigma0: member.sigma0[fold], ..Estimator::of(law) }, *inside)
        };
        // What it held out does not weigh the members that are judged by it.
        let mean = mean_of(members.iter().map(stub).collect(), &weights(members, runs, Some(fold)));
        let combined = |(k, stretch): (usize, &Stretch)| {
            let row = |i: usize| {
                mean.combined(members.iter().map(|(member, _)| member.outputs[fold][k].estimates[i]))
            };
            Stretch { estimates: (0..stretch.estimates.len()).map(row).collect(), ..*stretch }
        };
        let outputs = first.outputs[fold].iter().enumerate().map(combined).collect();
        validation.push(mean.sigma0, outputs, runs, of)?;
    }
    validation.concluded(of)
}

/// Weights of members, of each whether it counts inside the training data alone, by all folds but `without`:
/// above zero, with the sum 1.
///
/// ```text
/// w = (1 - a) arg min_v sum_f (1 / (n_f s_f)) sum_i (sum_k v_k e_k,i)^2 + a / K,   v >= 0,   sum_k v_k = 1
/// ```
///
/// `e_k,i` is the error of member `k` of `K` on held-out sample `i` of the `n_f` of fold `f` where all of
/// them count, `s_f` the mean of their mean squares there: folds of any length and difficulty count alike.
/// `a` is 0.25, and 1 with fewer than 12 recordings.
///
/// # Source
/// Stacked regressions: `breiman1996`.
fn weights(members: &[(&CrossValidation, bool)], runs: &[Run], without: Option<usize>) -> Vec<f64> {
    let count = members.len();
    let mut products = Matrix::zeros(count);
    let folds = members.first().map_or(&[][..], |(first, _)| &first.outputs);
    let mut recordings: Vec<usize> = folds.iter().flatten().map(|stretch| stretch.sequence).collect();
    recordings.sort_unstable();
    recordings.dedup();
    let equal = if recordings.len() < RECORDINGS { 1.0 } else { EQUAL };
    for fold in (0..folds.len()).filter(|fold| Some(*fold) != without) {
        let of_fold = products_of_errors(members, runs, fold);
        let trace: f64 = (0..count).map(|k| of_fold[(k, k)]).sum();
        if trace > 0.0 {
            for (i, j) in pairs(count) {
                products[(i, j)] += of_fold[(i, j)] / trace;
            }
        }
    }
    let best = least_on_simplex(&products).unwrap_or_else(|| vec![1.0 / count as f64; count]);
    best.iter().map(|w| (1.0 - equal) * w + equal / count as f64).collect()
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (0..count).map(move |j| (i, j)))
}

/// `sum_i e_k,i e_l,i` over the samples of a fold where all members count: `[members x members]`.
fn products_of_errors(members: &[(&CrossValidation, bool)], runs: &[Run], fold: usize) -> Matrix {
    let fades = members.iter().any(|(_, inside)| *inside);
    let mut products = Matrix::zeros(members.len());
    for (k, stretch) in members[0].0.outputs[fold].iter().enumerate() {
        let run = &runs[stretch.sequence];
        for i in 0..stretch.estimates.len() {
            let row = stretch.from + i;
            let of = |(member, _): &(&CrossValidation, bool)| member.outputs[fold][k].estimates[i];
            let outside = fades && members.iter().any(|member| !member.1 && of(member).beyond > 0.0);
            if run.weight[row] > 0.0 && !outside {
                let errors: Vec<f64> = members.iter().map(|member| of(member).mean - run.far[row]).collect();
                for (i, j) in pairs(errors.len()) {
                    products[(i, j)] += errors[i] * errors[j];
                }
            }
        }
    }
    products
}

/// The least of `v^T G v` over `v >= 0` with the sum 1: of every subset of the entries the solution without
/// bounds, `G_S^-1 1` over its sum, as far as it is positive. `None` where `G` is zero.
fn least_on_simplex(g: &Matrix) -> Option<Vec<f64>> {
    let count = g.size();
    let of_subset = |subset: usize| {
        let members: Vec<usize> = (0..count).filter(|k| subset >> k & 1 == 1).collect();
        let sub = Matrix::from_fn(members.len(), |i, j| g[(members[i], members[j])]);
        let solved = Cholesky::new(sub)?.solve(&vec![1.0; members.len()])?;
        let sum: f64 = solved.iter().sum();
        if !(solved.iter().all(|v| *v >= 0.0) && sum > 0.0 && sum.is_finite()) {
            return None;
        }
        let mut all = vec![0.0; count];
        members.iter().zip(&solved).for_each(|(k, v)| all[*k] = v / sum);
        Some((1.0 / sum, all))
    };
    let found = (1..1_usize << count).filter_map(of_subset);
    found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, all)| all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::predictor::Estimate;

    fn least(rows: [[f64; 3]; 3]) -> Vec<f64> {
        least_on_simplex(&Matrix::from_fn(3, |i, j| rows[i][j])).unwrap()
    }

    #[test]
    fn members_whose_errors_are_independent_count_by_the_inverse_of_their_mean_squares() {
        let found = least([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]]);
        for (w, desired) in found.iter().zip([4.0 / 7.0, 2.0 / 7.0, 1.0 / 7.0]) {
            assert!((w - desired).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn no_weights_of_a_grid_are_better_and_a_member_that_only_adds_error_gets_none() {
        let g = [[1.0, 1.2, 0.3], [1.2, 2.0, 0.1], [0.3, 0.1, 3.0]];
        let cost = |v: &[f64]| -> f64 { pairs(3).map(|(i, j)| v[i] * g[i][j] * v[j]).sum() };
        let found = least(g);
        assert!(found[1].abs() < 1e-12 && found.iter().all(|v| *v >= 0.0), "{found:?}");
        for a in 0..=50 {
            for b in 0..=50 - a {
                let v = [a, b, 50 - a - b].map(|k| f64::from(k) / 50.0);
                assert!(cost(&found) <= cost(&v) + 1e-12, "{v:?} is better than {found:?}");
            }
        }
    }

    #[test]
    fn a_mean_errs_less_than_members_that_err_to_either_side_and_its_spread_is_in_its_band() {
        let run = Run {
            log: 0,
            dt_s: vec![0.01; 40],
            inputs: vec![0.0; 40],
            far: (0..40).map(f64::from).collect(),
            weight: vec![1.0; 40],
            width: 1,
        };
        let folds = Folds {
            held_out: vec![vec![Some((0, 20))], vec![Some((20, 40))]],
            grouped: false,
            question: String::new(),
        };
        let runs = [run];
        // A member that is off by a constant; its estimates are stated, none is fitted.
        let member = |off: f64| {
            let mut validation = CrossValidation::default();
            for from in [0, 20] {
                let estimate = |row: usize| Estimate {
                    mean: row as f64 + off,
                    variance: 0.04,
                    gate: 1.0,
                    known: true,
                    clipped: 0,
                    beyond: 0.0,
                };
                let estimates = (from..from + 20).map(estimate).collect();
                let outputs = vec![Stretch { sequence: 0, from, estimates }];
                validation.push(0.2, outputs, &runs, 2).unwrap();
            }
            validation.concluded(2).unwrap()
        };
        let (above, below) = (member(1.0), member(-0.5));
        let mean = mean_validation(&[(&above, false), (&below, false)], &runs, &folds).unwrap();
        assert!((mean.score(None) - 0.25).abs() < 1e-9 && (above.score(None) - 1.0).abs() < 1e-9);
        let rows: Vec<_> = mean.rows().collect();
        assert_eq!(rows.len(), 40);
        // 0.2 of the fit and 0.75 between the members.
        assert!(rows.iter().all(|(.., e, _)| (e.variance - 0.04 - 0.75 * 0.75).abs() < 1e-9));
        assert!(mean_validation(&[], &runs, &folds).is_err());
    }
}
