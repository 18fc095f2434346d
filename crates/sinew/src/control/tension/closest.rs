//! The closest torque to one that is out of reach, from the limits that hold there.

use super::block::{Block, Limit};
use super::pattern::places;
use super::rows::{Rows, dot};
use alloc::vec::Vec;

/// What the search works in.
#[derive(Debug, Clone, Default)]
pub(super) struct Closest {
    /// Muscles between their limits.
    free: Vec<usize>,
    /// Orthogonal basis of what they can do to the joints, row by row, with the inverse squares of its rows' lengths;
    /// their arms in it, row by row, lower triangle with ones on the diagonal.
    basis: Vec<f64>,
    inverse: Vec<f64>,
    arms: Vec<f64>,
    /// The torque that the free muscles are asked for, in the basis.
    asked: Vec<f64>,
    along: Vec<f64>,
    /// What stays of the torque.
    pub(super) residual: Vec<f64>,
    /// The question for the muscles that have a choice: the others stay where they are, the torque is the closest.
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) torque: Vec<f64>,
}

/// What the limits that hold say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Only these tensions give the closest torque.
    Unique,
    /// Others give it, too.
    Choice,
    /// Other limits hold, or rounding hides which.
    Doubtful,
}

/// Part of a row of arms that others leave of it: none, and enough to divide by. All lengths are compared by their
/// squares.
const DEPENDENT: f64 = 1e-12 * 1e-12;
const INDEPENDENT: f64 = 1e-4 * 1e-4;

/// Least residual relative to what it is made of.
const CLEAR: f64 = 1e-7 * 1e-7;

/// Wish to leave a limit: rounding relative to what the residual is made of, and no rounding, relative to the residual.
const ROUNDING: f64 = 1e-14 * 1e-14;
const CERTAIN: f64 = 1e-9 * 1e-9;

/// Takes from `x` what the basis has of it, and adds that to `part`; twice, so that rounding leaves nothing. `along` is
/// room for as many.
#[inline(always)]
fn project(basis: &[f64], inverse: &[f64], x: &mut [f64], part: &mut [f64], along: &mut [f64]) {
    let n = x.len();
    let along = &mut along[..inverse.len()];
    for _ in 0..2 {
        // All first, then all taken: they need not wait for each other.
        for (k, row) in basis.chunks_exact(n).enumerate() {
            along[k] = dot(row, x) * inverse[k];
            part[k] += along[k];
        }
        for (along, row) in along.iter().zip(basis.chunks_exact(n)) {
            x.iter_mut().zip(row).for_each(|(x, row)| *x -= along * row);
        }
    }
}

impl Closest {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let joints = places(joints);
        Self {
            free: Vec::with_capacity(muscles),
            basis: Vec::with_capacity(joints * joints),
            inverse: Vec::with_capacity(joints),
            arms: Vec::with_capacity(joints * joints),
            asked: alloc::vec![0.0; joints],
            along: alloc::vec![0.0; joints],
            residual: alloc::vec![0.0; joints],
            lower: alloc::vec![0.0; muscles],
            upper: alloc::vec![0.0; muscles],
            torque: alloc::vec![0.0; joints],
        }
    }

    /// Takes limits for those that hold at the closest torque, and proves it.
    ///
    /// ```text
    /// r = b - Q D^-1 Q^T b,   b = tau - sum_held R_i F_i,   Q: orthogonal basis of the free muscles' arms, Q^T Q = D
    /// R_i r >= 0 where F_max holds,   R_i r <= 0 where F_min holds
    /// ```
    #[inline(always)]
    pub(super) fn judge<R: Rows>(&mut self, block: &Block<R>, limit: &[Limit]) -> Verdict {
        let (m, n) = (block.muscles(), block.joints());
        let size = self.ask(block, limit);
        let Some(mut unique) = self.span(block) else { return Verdict::Doubtful };
        let residual = &mut self.residual[..n];
        self.asked[..n].fill(0.0);
        project(&self.basis, &self.inverse, residual, &mut self.asked, &mut self.along);
        let residual = &self.residual[..n];
        let (left, size) = (dot(residual, residual), size * size);
        if self.inverse.len() == n || left <= CLEAR * size {
            return Verdict::Doubtful;
        }
        for (i, limit) in limit[..m].iter().enumerate() {
            (self.lower[i], self.upper[i]) = (block.lower[i], block.upper[i]);
            if *limit == Limit::Free || block.lower[i] >= block.upper[i] {
                continue;
            }
            let arm: f64 = block.rows.row(i).map(|(_, arm)| arm * arm).sum();
            let wish = block.rows.dot(i, residual);
            if wish * wish <= ROUNDING * arm * size {
                unique = false;
            } else if wish * wish <= arm * (CERTAIN * left + 100.0 * ROUNDING * size)
                || (wish > 0.0) != (*limit == Limit::Upper)
            {
                return Verdict::Doubtful;
            } else if *limit == Limit::Upper {
                self.lower[i] = self.upper[i];
            } else {
                self.upper[i] = self.lower[i];
            }
        }
        for (torque, (wanted, left)) in self.torque.iter_mut().zip(block.torque.iter().zip(residual)) {
            *torque = wanted - left;
        }
        if unique { Verdict::Unique } else { Verdict::Choice }
    }

    /// Lists the free muscles and puts what the others leave of the torque into the residual; what that is made of.
    #[inline(always)]
    fn ask<R: Rows>(&mut self, block: &Block<R>, limit: &[Limit]) -> f64 {
        let n = block.joints();
        self.free.clear();
        self.residual[..n].copy_from_slice(&block.torque[..n]);
        let mut size: f64 = block.torque[..n].iter().map(|torque| torque.abs()).sum();
        for (i, limit) in limit[..block.muscles()].iter().enumerate() {
            let tension = match limit {
                Limit::Lower => block.lower[i],
                Limit::Upper => block.upper[i],
                Limit::Free => {
                    self.free.push(i);
                    continue;
                }
            };
            for (joint, arm) in block.rows.row(i) {
                self.residual[joint] -= arm * tension;
                size += (arm * tension).abs();
            }
        }
        size
    }

    /// Makes the basis; whether the free muscles' arms are independent, unless that is hard to tell.
    #[inline(always)]
    fn span<R: Rows>(&mut self, block: &Block<R>) -> Option<bool> {
        let n = block.joints();
        let mut unique = true;
        self.basis.clear();
        self.inverse.clear();
        self.arms.clear();
        for &i in &self.free {
            let rank = self.inverse.len();
            if rank == n {
                return None;
            }
            let (at, row) = (self.basis.len(), self.arms.len());
            self.basis.resize(at + n, 0.0);
            self.arms.resize(row + n, 0.0);
            let (basis, next) = self.basis.split_at_mut(at);
            block.rows.row(i).for_each(|(joint, arm)| next[joint] = arm);
            let whole = dot(next, next);
            project(basis, &self.inverse, next, &mut self.arms[row..row + rank], &mut self.along);
            let left = dot(next, next);
            if left > INDEPENDENT * whole {
                self.inverse.push(1.0 / left);
            } else if left <= DEPENDENT * whole {
                unique = false;
                self.basis.truncate(at);
                self.arms.truncate(row);
            } else {
                return None;
            }
        }
        Some(unique)
    }

    /// Tensions of the free muscles and their multipliers, where the verdict is unique; whether they keep the limits.
    ///
    /// ```text
    /// R_free = L Q^T,   Q^T Q = D        L^T F = D^-1 Q^T b        L y = W (F - F_ref),   lambda = Q D^-1 y
    /// ```
    #[inline(always)]
    pub(super) fn solve<R: Rows>(
        &mut self,
        block: &Block<R>,
        lambda: &mut [f64],
        tension: &mut [f64],
    ) -> bool {
        let (n, rank) = (block.joints(), self.free.len());
        let asked = &mut self.asked[..rank];
        for k in (0..rank).rev() {
            let (below, from) = asked.split_at_mut(k);
            let row = &self.arms[k * n..k * n + k];
            below.iter_mut().zip(row).for_each(|(asked, arm)| *asked -= arm * from[0]);
        }
        for (&i, asked) in self.free.iter().zip(&*asked) {
            if !(block.lower[i] < *asked && *asked < block.upper[i]) {
                return false;
            }
        }
        let m = block.muscles();
        tension[..m].copy_from_slice(&self.lower[..m]);
        lambda.fill(0.0);
        for (k, &i) in self.free.iter().enumerate() {
            tension[i] = asked[k];
            let wanted = (asked[k] - block.reference[i]) / block.compliance[i];
            asked[k] = wanted - dot(&self.arms[k * n..k * n + k], &asked[..k]);
            let along = asked[k] * self.inverse[k];
            let basis = &self.basis[k * n..(k + 1) * n];
            lambda.iter_mut().zip(basis).for_each(|(lambda, basis)| *lambda += along * basis);
        }
        true
    }
}
