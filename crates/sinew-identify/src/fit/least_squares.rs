//! Least squares of a few parameters from residuals alone, with the covariance that confidence intervals
//! need.
//!
//! ```text
//! minimise |r(theta)|^2,   cov(theta) = s^2 (J^T J)^-1
//! ```
//!
//! Meant for some dozens of parameters: the Jacobian is stored.

use super::levenberg_marquardt::{self as search, Adaptation, Damping, Limits, Scaling};
use super::linear_algebra::{Matrix, symmetric_eigen};
use super::linearisation::Linearisation;
use super::prior::Prior;

/// A sum of squared residuals, given by the residuals.
pub(crate) trait LeastSquares {
    /// Number of parameters, `p`.
    fn parameters(&self) -> usize;

    /// Number of residuals, `n`.
    fn residuals(&self) -> usize;

    /// Writes the residuals at `theta: [p]` into `residuals: [n]`; `false` where `theta` is outside the
    /// domain.
    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool;

    /// Writes the Jacobian `jacobian: [p x n]`, one row of `n` per parameter, at `theta: [p]`, where the
    /// residuals are `residuals: [n]`; `false` where a parameter cannot be moved.
    ///
    /// By default forward differences with a step of 1e-6 of the parameter, at least 1e-7.
    fn slopes(&self, theta: &[f64], residuals: &[f64], jacobian: &mut [f64]) -> bool {
        let mut moved = theta.to_vec();
        for (i, column) in jacobian.chunks_exact_mut(residuals.len().max(1)).enumerate() {
            let step = (1e-6 * theta[i].abs()).max(1e-7);
            let mut width = step;
            moved[i] = theta[i] + step;
            if !self.evaluate(&moved, column) {
                // At the edge of the domain, a backward difference.
                width = -step;
                moved[i] = theta[i] - step;
                if !self.evaluate(&moved, column) {
                    return false;
                }
            }
            for (slope, residual) in column.iter_mut().zip(residuals) {
                *slope = (*slope - residual) / width;
            }
            moved[i] = theta[i];
        }
        true
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Options {
    /// Accepted steps, at most.
    pub steps: usize,
    /// Stop when a step lowers the sum of squares by less than this fraction, twice in a row.
    pub tolerance: f64,
}

/// Parameters may have any scale.
const DAMPING: Damping = Damping {
    initial: 1e-3,
    min: 1e-12,
    scaling: Scaling::Diagonal { floor: 1e-11 },
    adaptation: Adaptation::Growing(4.0),
};

/// The best parameters found and the problem linearised there.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    /// Parameters, `[p]`.
    pub theta: Vec<f64>,
    /// Residuals there, `[n]`.
    pub residuals: Vec<f64>,
    /// Sum of their squares.
    pub squares: f64,
    /// Lower triangle of `J^T J` there, `[p x p]`.
    normal: Matrix,
}

/// Searches from `start: [p]`; `None` where the problem cannot be evaluated there.
pub(crate) fn solve(problem: &impl LeastSquares, start: &[f64], options: Options) -> Option<Solution> {
    let (theta, _) = minimise(problem, start, options)?;
    linearise(problem, theta)
}

/// The best parameters, `[p]`, and their squares, without what the data determine of them.
pub(crate) fn minimise(
    problem: &impl LeastSquares,
    start: &[f64],
    options: Options,
) -> Option<(Vec<f64>, f64)> {
    let p = problem.parameters();
    if start.len() != p {
        return None;
    }
    let mut dense = Dense::new(problem);
    let limits =
        Limits { steps: options.steps, trials: usize::MAX, tolerance: options.tolerance, small_steps: 2 };
    let found = search::minimise(&mut dense, start.to_vec(), &mut Prior::none(p), &DAMPING, &limits)?;
    Some((found.theta, found.cost))
}

/// A solution from its parameters, `[p]`; `None` where the problem cannot be evaluated there.
pub(crate) fn linearise(problem: &impl LeastSquares, theta: Vec<f64>) -> Option<Solution> {
    let mut dense = Dense::new(problem);
    let mut at = Linearisation::zeros(theta.len());
    if !search::Problem::linearise(&mut dense, &theta, &mut at) {
        return None;
    }
    let Linearisation { squares, normal, .. } = at;
    Some(Solution { theta, residuals: dense.residuals, squares, normal })
}

/// The best of several starts; ties go to the earlier one.
pub(crate) fn solve_from_many(
    problem: &impl LeastSquares,
    starts: &[Vec<f64>],
    options: Options,
) -> Option<Solution> {
    let mut best: Option<Solution> = None;
    for start in starts {
        if let Some(found) = solve(problem, start, options)
            && best.as_ref().is_none_or(|best| found.squares < best.squares)
        {
            best = Some(found);
        }
    }
    best
}

/// Residuals and stored Jacobian as a problem of the search.
struct Dense<'a, P> {
    problem: &'a P,
    /// Where the residuals are known: `[p]`.
    at: Option<Vec<f64>>,
    residuals: Vec<f64>,
    /// `[p x n]`.
    jacobian: Vec<f64>,
}

impl<'a, P: LeastSquares> Dense<'a, P> {
    fn new(problem: &'a P) -> Self {
        let (p, n) = (problem.parameters(), problem.residuals());
        Self { problem, at: None, residuals: vec![0.0; n], jacobian: vec![0.0; n * p] }
    }

    fn evaluate(&mut self, theta: &[f64]) -> bool {
        let inside = self.problem.evaluate(theta, &mut self.residuals);
        self.at = inside.then(|| theta.to_vec());
        inside
    }
}

impl<P: LeastSquares> search::Problem for Dense<'_, P> {
    fn squares(&mut self, theta: &[f64]) -> Option<f64> {
        self.evaluate(theta).then(|| dot(&self.residuals, &self.residuals))
    }

    fn linearise(&mut self, theta: &[f64], at: &mut Linearisation) -> bool {
        // An accepted step was evaluated last.
        let known = self.at.as_deref() == Some(theta) || self.evaluate(theta);
        if !known || !self.problem.slopes(theta, &self.residuals, &mut self.jacobian) {
            return false;
        }
        let n = self.residuals.len();
        let row = |i: usize| &self.jacobian[i * n..][..n];
        at.squares = dot(&self.residuals, &self.residuals);
        for i in 0..theta.len() {
            at.gradient[i] = dot(row(i), &self.residuals);
            for j in 0..=i {
                at.normal[(i, j)] = dot(row(i), row(j));
            }
        }
        true
    }
}

/// Four running sums, so that the compiler may vectorise; always in the same order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (heads, tails) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = heads.remainder().iter().zip(tails.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in heads.zip(tails) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// What the data determine of each parameter: the inverse of `J^T J`, by its eigenvalues.
#[derive(Debug, Clone)]
pub(crate) struct Covariance {
    /// Diagonal of the inverse, `[p]`, to be multiplied by the variance of the residuals;
    /// infinite where the data do not determine the parameter.
    pub variance: Vec<f64>,
    /// The whole inverse, `[p x p]`; directions that the data do not determine are left out of it.
    pub matrix: Matrix,
    /// Condition number of `J^T J` scaled to a unit diagonal; infinite where a parameter has no effect.
    pub condition: f64,
}

impl Solution {
    /// Conditioning and inverse of the normal matrix at the solution.
    pub(crate) fn covariance(&self) -> Covariance {
        covariance(&self.normal)
    }
}

fn covariance(normal: &Matrix) -> Covariance {
    /// Relative size below which an eigenvalue of the scaled matrix is rounding (finite differences).
    const NOISE: f64 = 1e-11;
    /// A parameter counts as undetermined with its fraction in an undetermined direction above this.
    const MIN_FRACTION: f64 = 1e-3;
    let p = normal.size();
    let largest = (0..p).map(|i| normal[(i, i)]).fold(0.0, f64::max);
    // A parameter without effect has a zero row and is left out.
    let scale: Vec<f64> = (0..p)
        .map(|i| {
            let d = normal[(i, i)];
            if d > largest * 1e-30 { 1.0 / d.sqrt() } else { 0.0 }
        })
        .collect();
    let scaled = Matrix::from_fn(p, |i, j| normal[(i.max(j), i.min(j))] * scale[i] * scale[j]);
    let (mut variance, mut matrix) = (vec![0.0; p], Matrix::zeros(p));
    let Some((values, vectors)) = symmetric_eigen(&scaled) else {
        return Covariance { variance: vec![f64::INFINITY; p], matrix, condition: f64::INFINITY };
    };
    let top = values.iter().copied().fold(0.0, f64::max);
    let bottom = values.iter().copied().fold(f64::INFINITY, f64::min);
    for (k, &value) in values.iter().enumerate() {
        for i in 0..p {
            let component = vectors[(i, k)];
            if value <= NOISE * top {
                if component.abs() > MIN_FRACTION {
                    variance[i] = f64::INFINITY;
                }
                continue;
            }
            for j in 0..p {
                matrix[(i, j)] += scale[i] * scale[j] * component * vectors[(j, k)] / value;
            }
        }
    }
    for i in 0..p {
        variance[i] += matrix[(i, i)];
    }
    let condition = if bottom > 0.0 && p > 0 { top / bottom } else { f64::INFINITY };
    Covariance { variance, matrix, condition }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: Options = Options { steps: 60, tolerance: 1e-8 };

    /// `y = a exp(-b x)`, and a third parameter without effect.
    struct Decay {
        data: Vec<(f64, f64)>,
        idle: bool,
    }

    impl LeastSquares for Decay {
        fn parameters(&self) -> usize {
            2 + usize::from(self.idle)
        }
        fn residuals(&self) -> usize {
            self.data.len()
        }
        fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool {
            for (r, (x, y)) in residuals.iter_mut().zip(&self.data) {
                *r = theta[0] * (-theta[1] * x).exp() - y;
            }
            theta[1] > 0.0
        }
    }

    fn decay(idle: bool) -> Decay {
        let data = (0..50).map(|i| f64::from(i) * 0.1).map(|x| (x, 3.0 * (-1.2 * x).exp())).collect();
        Decay { data, idle }
    }

    #[test]
    fn exact_data_give_the_exact_parameters() {
        let found = solve(&decay(false), &[1.0, 0.2], OPTIONS).unwrap();
        assert!((found.theta[0] - 3.0).abs() < 1e-6 && (found.theta[1] - 1.2).abs() < 1e-6, "{found:?}");
        let covariance = found.covariance();
        assert!(covariance.condition > 1.0 && covariance.condition < 100.0);
        // The inverse is an inverse.
        let product: f64 = (0..2).map(|k| found.normal[(k, 0)] * covariance.matrix[(k, 0)]).sum();
        assert!((product - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_parameter_without_effect_has_infinite_variance_and_does_not_affect_the_others() {
        let found = solve(&decay(true), &[1.0, 0.2, 7.0], OPTIONS).unwrap();
        assert!((found.theta[1] - 1.2).abs() < 1e-6);
        let covariance = found.covariance();
        assert!(covariance.variance[2].is_infinite() && covariance.condition.is_infinite());
        assert!(covariance.variance[0].is_finite());
    }

    #[test]
    fn starts_outside_the_domain_are_refused_and_the_best_start_wins() {
        assert!(solve(&decay(false), &[1.0, -1.0], OPTIONS).is_none());
        assert!(solve(&decay(false), &[1.0], OPTIONS).is_none());
        let starts = vec![vec![1.0, -1.0], vec![0.1, 50.0], vec![1.0, 0.2]];
        let found = solve_from_many(&decay(false), &starts, OPTIONS).unwrap();
        assert!(found.squares < 1e-9);
    }
}
