//! Levenberg-Marquardt for small dense problems, with what is needed for honest intervals.
//!
//! ```text
//! (J^T J + mu diag(J^T J)) d = -J^T r,    theta <- theta + d     where that lowers |r|^2
//! ```
//!
//! Meant for up to some dozens of parameters: the normal matrix is factorised by a plain Cholesky.
//!
//! # Source
//! `levenberg1944`, `marquardt1963`.

/// A sum of squares to be made small.
pub trait LeastSquares {
    /// Number of parameters, `p`.
    fn parameters(&self) -> usize;

    /// Number of residuals, `n`.
    fn residuals(&self) -> usize;

    /// Writes the residuals at `theta: [p]` into `residuals: [n]`; `false` where `theta` is outside the domain.
    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool;

    /// Writes residuals and Jacobian `jacobian: [p x n]`, one row of `n` per parameter.
    ///
    /// By default forward differences with a step of 1e-6 of the parameter, at least 1e-7.
    fn linearise(&self, theta: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) -> bool {
        if !self.evaluate(theta, residuals) {
            return false;
        }
        let mut moved = theta.to_vec();
        for (i, column) in jacobian.chunks_exact_mut(residuals.len().max(1)).enumerate() {
            let step = (1e-6 * theta[i].abs()).max(1e-7);
            let mut taken = step;
            moved[i] = theta[i] + step;
            if !self.evaluate(&moved, column) {
                // At the edge of the domain the other side serves.
                taken = -step;
                moved[i] = theta[i] - step;
                if !self.evaluate(&moved, column) {
                    return false;
                }
            }
            for (slope, residual) in column.iter_mut().zip(residuals.iter()) {
                *slope = (*slope - residual) / taken;
            }
            moved[i] = theta[i];
        }
        true
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Accepted steps, at most.
    pub steps: usize,
    /// Stop when a step lowers the sum of squares by less than this fraction, twice in a row.
    pub tolerance: f64,
    /// First damping.
    pub damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { steps: 60, tolerance: 1e-8, damping: 1e-3 }
    }
}

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Further steps gain nothing.
    Converged,
    /// [`Options::steps`] were taken.
    StepLimit,
}

/// The best parameters found and the problem seen from there.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Parameters, `[p]`.
    pub theta: Vec<f64>,
    /// Residuals there, `[n]`.
    pub residuals: Vec<f64>,
    /// Sum of their squares.
    pub squares: f64,
    /// `J^T J` there, `[p x p]`.
    pub normal: Vec<f64>,
    /// Accepted steps.
    pub steps: usize,
    /// Why the search ended.
    pub status: Status,
}

/// Searches from `start: [p]`; `None` where the problem cannot be evaluated there.
#[must_use]
pub fn minimise(problem: &impl LeastSquares, start: &[f64], options: Options) -> Option<Solution> {
    let (p, n) = (problem.parameters(), problem.residuals());
    if start.len() != p {
        return None;
    }
    let mut theta = start.to_vec();
    let (mut residuals, mut trial_residuals) = (vec![0.0; n], vec![0.0; n]);
    let mut jacobian = vec![0.0; n * p];
    if !problem.linearise(&theta, &mut residuals, &mut jacobian) {
        return None;
    }
    let mut squares = finite_squares(&residuals)?;
    let (mut normal, mut gradient) = normal_equations(&jacobian, &residuals, p);
    let (mut damping, mut growth, mut small, mut steps) = (options.damping, 2.0, 0, 0);
    let mut status = Status::StepLimit;
    while steps < options.steps {
        let Some(step) = damped_step(&normal, &gradient, damping) else {
            status = Status::Converged;
            break;
        };
        let trial: Vec<f64> = theta.iter().zip(&step).map(|(t, d)| t + d).collect();
        let evaluated = problem.evaluate(&trial, &mut trial_residuals);
        let better = if evaluated { finite_squares(&trial_residuals) } else { None }.filter(|s| *s < squares);
        let Some(lower) = better else {
            damping *= growth;
            growth *= 2.0;
            if damping > 1e12 {
                status = Status::Converged;
                break;
            }
            continue;
        };
        let gain = (squares - lower) / squares;
        theta = trial;
        steps += 1;
        (damping, growth) = ((damping / 4.0).max(1e-12), 2.0);
        if !problem.linearise(&theta, &mut residuals, &mut jacobian) {
            return None;
        }
        squares = lower;
        (normal, gradient) = normal_equations(&jacobian, &residuals, p);
        small = if gain < options.tolerance { small + 1 } else { 0 };
        if small == 2 || squares <= 0.0 {
            status = Status::Converged;
            break;
        }
    }
    Some(Solution { theta, residuals, squares, normal, steps, status })
}

/// The best of several starts; ties go to the earlier one.
#[must_use]
pub fn minimise_from_many(
    problem: &impl LeastSquares,
    starts: &[Vec<f64>],
    options: Options,
) -> Option<Solution> {
    let mut best: Option<Solution> = None;
    for start in starts {
        if let Some(found) = minimise(problem, start, options)
            && best.as_ref().is_none_or(|best| found.squares < best.squares)
        {
            best = Some(found);
        }
    }
    best
}

/// What the data say about each parameter: the inverse of `J^T J`, taken apart by its eigenvalues.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Diagonal of the inverse, `[p]`, to be multiplied by the variance of the residuals;
    /// infinite where the data do not determine the parameter.
    pub variance: Vec<f64>,
    /// The whole inverse, `[p x p]`; directions that the data do not determine are left out of it.
    pub matrix: Vec<f64>,
    /// Condition number of `J^T J` scaled to a unit diagonal; infinite where a parameter has no effect.
    pub condition: f64,
}

impl Solution {
    /// Conditioning and inverse of the normal matrix at the solution.
    #[must_use]
    pub fn covariance(&self) -> Covariance {
        covariance(&self.normal, self.theta.len())
    }
}

fn covariance(normal: &[f64], p: usize) -> Covariance {
    /// Relative size below which an eigenvalue of the scaled matrix is rounding (finite differences).
    const NOISE: f64 = 1e-11;
    let largest = (0..p).map(|i| normal[i * p + i]).fold(0.0, f64::max);
    // A parameter without effect has a zero row; scale it by infinity, that is, leave it out.
    let scale: Vec<f64> = (0..p)
        .map(|i| {
            let d = normal[i * p + i];
            if d > largest * 1e-30 { 1.0 / d.sqrt() } else { 0.0 }
        })
        .collect();
    let scaled: Vec<f64> = (0..p * p).map(|ij| normal[ij] * scale[ij / p] * scale[ij % p]).collect();
    let (values, vectors) = symmetric_eigen(scaled, p);
    let top = values.iter().copied().fold(0.0, f64::max);
    let bottom = values.iter().copied().fold(f64::INFINITY, f64::min);
    let condition = if bottom > 0.0 && p > 0 { top / bottom } else { f64::INFINITY };
    let mut covariance = vec![0.0; p * p];
    let mut variance = vec![0.0; p];
    for (k, &value) in values.iter().enumerate() {
        for i in 0..p {
            let vi = vectors[i * p + k];
            if value <= NOISE * top {
                if vi.abs() > 1e-3 {
                    variance[i] = f64::INFINITY;
                }
                continue;
            }
            for j in 0..p {
                covariance[i * p + j] += scale[i] * scale[j] * vi * vectors[j * p + k] / value;
            }
        }
    }
    for i in 0..p {
        variance[i] += covariance[i * p + i];
    }
    Covariance { variance, matrix: covariance, condition }
}

fn finite_squares(residuals: &[f64]) -> Option<f64> {
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    squares.is_finite().then_some(squares)
}

fn normal_equations(jacobian: &[f64], residuals: &[f64], p: usize) -> (Vec<f64>, Vec<f64>) {
    let row = |i: usize| &jacobian[i * residuals.len()..(i + 1) * residuals.len()];
    let mut normal = vec![0.0; p * p];
    let mut gradient = vec![0.0; p];
    for i in 0..p {
        gradient[i] = dot(row(i), residuals);
        for j in 0..=i {
            normal[i * p + j] = dot(row(i), row(j));
            normal[j * p + i] = normal[i * p + j];
        }
    }
    (normal, gradient)
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

/// `None` where the damped matrix is not positive definite, or the gradient is zero.
fn damped_step(normal: &[f64], gradient: &[f64], damping: f64) -> Option<Vec<f64>> {
    let p = gradient.len();
    let largest = (0..p).map(|i| normal[i * p + i]).fold(0.0, f64::max);
    if gradient.iter().all(|g| g.abs() <= 0.0) {
        return None;
    }
    let mut damped = normal.to_vec();
    for i in 0..p {
        let d = normal[i * p + i];
        damped[i * p + i] += damping * d + 1e-14 * largest;
    }
    let downhill: Vec<f64> = gradient.iter().map(|g| -g).collect();
    solve_positive(damped, downhill)
}

/// Solves `A x = b` for a symmetric positive definite `A: [p x p]`; `None` where it is not.
#[must_use]
pub fn solve_positive(mut a: Vec<f64>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let p = b.len();
    for j in 0..p {
        let d = a[j * p + j] - (0..j).map(|k| a[j * p + k] * a[j * p + k]).sum::<f64>();
        if !(d > 0.0 && d.is_finite()) {
            return None;
        }
        a[j * p + j] = d.sqrt();
        for i in j + 1..p {
            let s: f64 = (0..j).map(|k| a[i * p + k] * a[j * p + k]).sum();
            a[i * p + j] = (a[i * p + j] - s) / a[j * p + j];
        }
    }
    for i in 0..p {
        let s: f64 = (0..i).map(|k| a[i * p + k] * b[k]).sum();
        b[i] = (b[i] - s) / a[i * p + i];
    }
    for i in (0..p).rev() {
        let s: f64 = (i + 1..p).map(|k| a[k * p + i] * b[k]).sum();
        b[i] = (b[i] - s) / a[i * p + i];
    }
    Some(b)
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix by Jacobi rotations.
fn symmetric_eigen(mut a: Vec<f64>, p: usize) -> (Vec<f64>, Vec<f64>) {
    let mut v = vec![0.0; p * p];
    for i in 0..p {
        v[i * p + i] = 1.0;
    }
    for _sweep in 0..60 {
        let off: f64 = (0..p * p).filter(|ij| ij / p != ij % p).map(|ij| a[ij] * a[ij]).sum();
        if off <= 1e-30 || off.is_nan() {
            break;
        }
        for i in 0..p {
            for j in i + 1..p {
                rotate(&mut a, &mut v, p, i, j);
            }
        }
    }
    ((0..p).map(|i| a[i * p + i]).collect(), v)
}

/// One Jacobi rotation that makes `a[i][j]` zero.
fn rotate(a: &mut [f64], v: &mut [f64], p: usize, i: usize, j: usize) {
    let off = a[i * p + j];
    if off.abs() <= 0.0 {
        return;
    }
    let tau = (a[j * p + j] - a[i * p + i]) / (2.0 * off);
    let t = 1.0_f64.copysign(tau) / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    for k in 0..p {
        let (x, y) = (a[k * p + i], a[k * p + j]);
        a[k * p + i] = c * x - s * y;
        a[k * p + j] = s * x + c * y;
    }
    for k in 0..p {
        let (x, y) = (a[i * p + k], a[j * p + k]);
        a[i * p + k] = c * x - s * y;
        a[j * p + k] = s * x + c * y;
        let (x, y) = (v[k * p + i], v[k * p + j]);
        v[k * p + i] = c * x - s * y;
        v[k * p + j] = s * x + c * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let found = minimise(&decay(false), &[1.0, 0.2], Options::default()).unwrap();
        assert_eq!(found.status, Status::Converged);
        assert!((found.theta[0] - 3.0).abs() < 1e-6 && (found.theta[1] - 1.2).abs() < 1e-6, "{found:?}");
        let covariance = found.covariance();
        assert!(covariance.condition > 1.0 && covariance.condition < 100.0);
        // The inverse is an inverse.
        let product: f64 = (0..2).map(|k| found.normal[k] * covariance.matrix[2 * k]).sum();
        assert!((product - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_parameter_without_effect_is_infinitely_uncertain_and_disturbs_nothing() {
        let found = minimise(&decay(true), &[1.0, 0.2, 7.0], Options::default()).unwrap();
        assert!((found.theta[1] - 1.2).abs() < 1e-6);
        let covariance = found.covariance();
        assert!(covariance.variance[2].is_infinite() && covariance.condition.is_infinite());
        assert!(covariance.variance[0].is_finite());
    }

    #[test]
    fn starts_outside_the_domain_are_refused_and_the_best_start_wins() {
        assert!(minimise(&decay(false), &[1.0, -1.0], Options::default()).is_none());
        assert!(minimise(&decay(false), &[1.0], Options::default()).is_none());
        let starts = vec![vec![1.0, -1.0], vec![0.1, 50.0], vec![1.0, 0.2]];
        let found = minimise_from_many(&decay(false), &starts, Options::default()).unwrap();
        assert!(found.squares < 1e-9);
    }

    #[test]
    fn eigenvalues_and_solutions_of_a_known_matrix() {
        let a = vec![4.0, 1.0, 1.0, 3.0];
        let (mut values, _) = symmetric_eigen(a.clone(), 2);
        values.sort_by(f64::total_cmp);
        let root = 5.0_f64.sqrt();
        assert!(
            (values[0] - (7.0 - root) / 2.0).abs() < 1e-12 && (values[1] - (7.0 + root) / 2.0).abs() < 1e-12
        );
        let x = solve_positive(a, vec![1.0, 2.0]).unwrap();
        assert!((x[0] - 1.0 / 11.0).abs() < 1e-12 && (x[1] - 7.0 / 11.0).abs() < 1e-12);
        assert!(solve_positive(vec![1.0, 2.0, 2.0, 1.0], vec![1.0, 1.0]).is_none());
    }
}
