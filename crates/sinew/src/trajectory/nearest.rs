use crate::body::vector::{dot, norm, product, solve_symmetric, sub};

/// The point of a box nearest to a preferred one that satisfies up to three linear equations.
///
/// ```text
/// min 1/2 (y - r)^T W (y - r)   so that   J y + eps (m - m_0) = b,   low <= y <= high
/// y(m) = clip(r + W^-1 J^T m, low, high)
/// ```
///
/// A semismooth Newton method finds the multipliers `m` of this strictly convex problem: the equation above
/// is piecewise linear in `m` and monotone, so that a line search in the direction of a Newton step
/// converges. With `eps > 0` there is a solution also where the equations contradict each other or the box.
///
/// # Source
/// Textbook: dual active-set method; `eps (m - m_0)` is the proximal point method's term.
pub(super) struct Nearest<'a> {
    /// `r`: `[n]`.
    pub(super) preferred: &'a [f64],
    /// Diagonal of `W`: `[n]`, > 0.
    pub(super) weight: &'a [f64],
    /// `[low, high]`: `[n]`.
    pub(super) bounds: &'a [[f64; 2]],
    /// `J`: `[3 x n]`; a row of zeros is no equation.
    pub(super) rows: &'a [f64],
    /// `b`.
    pub(super) right: [f64; 3],
    /// `eps`, > 0.
    pub(super) regularization: f64,
}

const MAX_ITERATIONS: usize = 60;
/// Residual at convergence, relative to the right side.
const TOLERANCE: f64 = 1e-15;

impl Nearest<'_> {
    /// Writes `y`; `multipliers` begin as `m_0` and become `m`.
    pub(super) fn solve(&self, y: &mut [f64], multipliers: &mut [f64; 3]) {
        let start = *multipliers;
        let scale = norm(self.right) + f64::MIN_POSITIVE;
        let mut residual = self.residual(start, start, y);
        for _ in 0..MAX_ITERATIONS {
            if norm(residual) <= TOLERANCE * scale {
                break;
            }
            let step = solve_symmetric(self.normal(y), residual).map(|x| -x);
            let slope = dot(residual, step);
            let mut fraction = 1.0;
            let mut trial = along(*multipliers, fraction, step);
            residual = self.residual(trial, start, y);
            if dot(residual, step) > 0.5 * slope.abs() {
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..50 {
                    fraction = 0.5 * (low + high);
                    trial = along(*multipliers, fraction, step);
                    residual = self.residual(trial, start, y);
                    let now = dot(residual, step);
                    if now.abs() <= 0.1 * slope.abs() {
                        break;
                    }
                    *(if now < 0.0 { &mut low } else { &mut high }) = fraction;
                }
            }
            *multipliers = trial;
        }
    }

    /// `J y(m) + eps (m - m_0) - b`; writes `y`.
    fn residual(&self, multipliers: [f64; 3], start: [f64; 3], y: &mut [f64]) -> [f64; 3] {
        let n = y.len();
        for (i, y) in y.iter_mut().enumerate() {
            let pull: f64 = (0..3).map(|k| self.rows[k * n + i] * multipliers[k]).sum();
            let [low, high] = self.bounds[i];
            *y = (self.preferred[i] + pull / self.weight[i]).max(low).min(high);
        }
        let moved = sub(multipliers, start);
        core::array::from_fn(|k| {
            product(&self.rows[k * n..(k + 1) * n], y) + self.regularization * moved[k] - self.right[k]
        })
    }

    /// `J_F W_F^-1 J_F^T + eps 1` of the coordinates between their bounds.
    fn normal(&self, y: &[f64]) -> [[f64; 3]; 3] {
        let n = y.len();
        let mut normal = [[0.0; 3]; 3];
        for (i, y) in y.iter().enumerate() {
            let [low, high] = self.bounds[i];
            if *y <= low || *y >= high {
                continue;
            }
            for (a, row) in normal.iter_mut().enumerate() {
                for (b, entry) in row.iter_mut().enumerate() {
                    *entry += self.rows[a * n + i] * self.rows[b * n + i] / self.weight[i];
                }
            }
        }
        for (k, row) in normal.iter_mut().enumerate() {
            row[k] += self.regularization;
        }
        normal
    }
}

fn along(from: [f64; 3], fraction: f64, step: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|k| from[k] + fraction * step[k])
}
