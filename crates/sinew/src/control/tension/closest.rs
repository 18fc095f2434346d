//! The closest torque to one out of reach, from the active set of the regularized dual.

use super::problem::Limit;
use super::rows::{Block, Rows, dot};
use super::scalar::Scalar;
use super::settings::Settings;
use alloc::vec::Vec;

/// The reduced problem of the muscles that have a choice: the others are fixed at their limits, and the
/// torque is the closest one.
#[derive(Debug, Clone)]
pub(super) struct Closest<S> {
    settings: Settings,
    /// Orthogonal basis of the rows of the free muscles, row by row, and the inverse squares of its rows'
    /// lengths.
    basis: Vec<S>,
    inverse: Vec<S>,
    along: Vec<S>,
    /// `tau - R^T F` of the closest torque.
    pub(super) residual: Vec<S>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    torque: Vec<S>,
}

impl<S: Scalar> Closest<S> {
    pub(super) fn new(muscles: usize, joints: usize, settings: &Settings) -> Self {
        Self {
            settings: *settings,
            basis: Vec::with_capacity(joints * joints),
            inverse: Vec::with_capacity(joints),
            along: alloc::vec![S::ZERO; joints],
            residual: alloc::vec![S::ZERO; joints],
            lower: alloc::vec![0.0; muscles],
            upper: alloc::vec![0.0; muscles],
            torque: alloc::vec![S::ZERO; joints],
        }
    }

    /// Makes the reduced problem from an active set, if that is proved to hold at the closest torque.
    ///
    /// ```text
    /// b = tau - sum_{i at limits} R_i^T F_i       Q: orthonormal basis of the free muscles' rows
    /// r = b - Q Q^T b
    /// R_i r >= 0 where F_max holds, <= 0 where F_min holds, = 0 where the muscle has a choice
    /// ```
    ///
    /// The reduced gradients `R_i r` are the optimality conditions of `min |tau - R^T F|` within the limits.
    /// False where they do not hold, or where rounding hides whether they do.
    pub(super) fn reduce<R: Rows>(&mut self, block: &Block<R, S>, limit: &[Limit]) -> bool {
        let n = block.joints();
        let tolerances = *S::tolerances(&self.settings);
        let size = self.subtract_limits(block, limit);
        if !self.orthogonalise(block, limit) {
            return false;
        }
        project_out(&self.basis, &self.inverse, &mut self.residual[..n], &mut self.along);
        let residual = &self.residual[..n];
        let left = norm(residual);
        if self.inverse.len() == n || left <= tolerances.least_residual * size {
            return false;
        }
        for (i, limit) in limit[..block.muscles()].iter().enumerate() {
            let (lower, upper) = (block.lower[i], block.upper[i]);
            (self.lower[i], self.upper[i]) = (lower, upper);
            if *limit == Limit::Free || lower >= upper {
                continue;
            }
            let length = libm::sqrt(block.rows.row(i).map(|(_, arm)| arm * arm).sum());
            let reduced_gradient = block.rows.dot(i, residual).rounded();
            let rounding = tolerances.rounding * length * size;
            if reduced_gradient.abs() <= rounding {
                continue;
            }
            let certain =
                reduced_gradient.abs() > 10.0 * rounding + tolerances.reduced_gradient * length * left;
            if !certain || (reduced_gradient > 0.0) != (*limit == Limit::Upper) {
                return false;
            }
            let at = if *limit == Limit::Upper { upper } else { lower };
            (self.lower[i], self.upper[i]) = (at, at);
        }
        for ((torque, desired), left) in self.torque.iter_mut().zip(block.torque).zip(residual) {
            *torque = *desired - *left;
        }
        true
    }

    /// The reduced problem.
    pub(super) fn reduced<'a, R: Rows>(&'a self, block: &Block<'a, R, S>) -> Block<'a, R, S> {
        let (m, n) = (block.muscles(), block.joints());
        Block { lower: &self.lower[..m], upper: &self.upper[..m], torque: &self.torque[..n], ..*block }
    }

    /// Puts what the muscles at limits leave of the torque into the residual; the magnitudes of its terms.
    fn subtract_limits<R: Rows>(&mut self, block: &Block<R, S>, limit: &[Limit]) -> f64 {
        let n = block.joints();
        self.residual[..n].copy_from_slice(&block.torque[..n]);
        let mut size: f64 = block.torque[..n].iter().map(|torque| torque.rounded().abs()).sum();
        for (i, limit) in limit[..block.muscles()].iter().enumerate() {
            let tension = match limit {
                Limit::Lower => block.lower[i],
                Limit::Upper => block.upper[i],
                Limit::Free => continue,
            };
            for (joint, arm) in block.rows.row(i) {
                self.residual[joint] -= S::from(arm) * tension;
                size += (arm * tension).abs();
            }
        }
        size
    }

    /// Makes the basis by Gram-Schmidt orthogonalisation; false where the rank is uncertain.
    fn orthogonalise<R: Rows>(&mut self, block: &Block<R, S>, limit: &[Limit]) -> bool {
        let n = block.joints();
        let [dependent, independent] = S::tolerances(&self.settings).rank;
        self.basis.clear();
        self.inverse.clear();
        for i in (0..block.muscles()).filter(|i| limit[*i] == Limit::Free) {
            let rank = self.inverse.len();
            if rank == n {
                return false;
            }
            self.basis.resize((rank + 1) * n, S::ZERO);
            let (basis, next) = self.basis.split_at_mut(rank * n);
            block.rows.row(i).for_each(|(joint, arm)| next[joint] = S::from(arm));
            let whole = norm(next);
            project_out(basis, &self.inverse, next, &mut self.along);
            let left = norm(next);
            if left > independent * whole {
                self.inverse.push(S::from(1.0) / dot(next, next));
            } else if left <= dependent * whole {
                self.basis.truncate(rank * n);
            } else {
                return false;
            }
        }
        true
    }
}

/// Takes from `x` its part in the span of the basis; twice, so that rounding leaves nothing of it.
fn project_out<S: Scalar>(basis: &[S], inverse: &[S], x: &mut [S], along: &mut [S]) {
    for _ in 0..2 {
        // All parts first, then all taken: they need not wait for each other.
        let rows = || basis.chunks_exact(x.len());
        for ((along, row), inverse) in along.iter_mut().zip(rows()).zip(inverse) {
            *along = dot(row, x) * *inverse;
        }
        for (along, row) in along.iter().zip(basis.chunks_exact(x.len())) {
            x.iter_mut().zip(row).for_each(|(x, row)| *x -= *along * *row);
        }
    }
}

fn norm<S: Scalar>(x: &[S]) -> f64 {
    libm::sqrt(dot(x, x).rounded())
}
