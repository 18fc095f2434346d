//! Weights of the members of a mean, by their errors on what the folds held out.

use super::cross_validation::CrossValidation;
use crate::fit::linear_algebra::{Cholesky, Matrix};
use crate::fit::run::Run;

/// Part of the weight that is the same for every member: one that is seldom right still shows by its spread
/// where none is certain.
const EQUAL: f64 = 0.25;

/// Recordings from which on their errors say which member is right: few differ by offsets of their own.
const RECORDINGS: usize = 12;

/// Weights of members, of each whether it counts inside the training data alone, by all folds but `without`:
/// above zero, with the sum 1.
///
/// ```text
/// w = (1 - a) arg min_v sum_f (1 / (n_f s_f)) sum_i (sum_k v_k e_k,i)^2 + a / K,   v >= 0,   sum_k v_k = 1
/// ```
///
/// `e_k,i` is the error of member `k` of `K` on held-out sample `i` of the `n_f` of fold `f` where all of them
/// count, `s_f` the mean of their mean squares there: folds of any length and difficulty count alike.
/// `a` is 0.25, and 1 with fewer than 12 recordings.
///
/// # Source
/// Stacked regressions: `breiman1996`.
pub(crate) fn weights(
    members: &[(&CrossValidation, bool)],
    runs: &[Run],
    without: Option<usize>,
) -> Vec<f64> {
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
}
