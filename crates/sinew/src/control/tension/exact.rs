//! The optimum where rounding or a torque out of reach stop Newton's method: slower, and never without an answer.

use super::anchored::{Anchored, dot};
use super::block::{Block, Limit};
use super::newton::{BALANCED, REACHED};
use super::pattern::places;
use super::rows::{Rows, Sparse};
use super::twofold::Twofold;
use alloc::vec::Vec;

/// What the search works in.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    held: Anchored,
    /// Per joint: what was left of the torque at the last anchor, and doubt about what is left.
    last: Vec<Twofold>,
    doubt: Vec<f64>,
}

/// Softness of the first anchor relative to the greatest stiffness of a joint: twice the digits hold a multiplier that
/// it lets grow.
const SOFTNESS: f64 = 1e-14;

/// Change of the residual, or residual, relative to what it is made of, that counts as none.
const STILL: f64 = 1e-16;

/// Wish to leave a limit, relative to the residual, that is no rounding.
const CERTAIN: f64 = 1e-13;

/// How much softer each anchor may be than the last, and the last than the first.
const SOFTER: f64 = 1e-2;
const SOFTEST: f64 = 1e-6;

/// Anchors at most. Each leaves but a small part of what the last left.
const ANCHORS: u32 = 100;

impl Exact {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            held: Anchored::new(muscles, joints),
            last: alloc::vec![Twofold::ZERO; places(joints)],
            doubt: alloc::vec![0.0; places(joints)],
        }
    }

    /// Tensions of least cost for the closest torque, and their multipliers.
    ///
    /// ```text
    /// max_lambda  dual(lambda) - eps/2 |lambda - anchor|^2           anchor := lambda, and again
    /// ```
    ///
    /// The anchor makes the stiffness regular and the multipliers finite whatever the arms are and whether or not the
    /// torque can be reached. Its optimum is that of `cost + |tau - R^T F + eps anchor|^2 / 2 eps`, so that the torque
    /// goes to the closest. What is out of reach moves the multipliers by `residual / eps` each time, without end: it
    /// is taken from the torque, muscles that would still lower it stay where they are, and what is left can be reached.
    ///
    /// # Source
    /// `chiche2014` for the augmented Lagrangian of infeasible problems, of which this is the dual.
    pub(super) fn solve(
        &mut self,
        block: &Block<Sparse>,
        lambda: &mut [f64],
        tension: &mut [f64],
        steps: &mut u32,
    ) {
        let m = block.muscles();
        self.begin(block);
        self.settle(block, steps);
        self.narrow(block);
        self.held.compliance[..m].copy_from_slice(block.compliance);
        self.settle(block, steps);
        for (tension, exact) in tension[..m].iter_mut().zip(&self.held.tension) {
            *tension = exact.rounded();
        }
        for (lambda, exact) in lambda.iter_mut().zip(&self.held.lambda) {
            *lambda = exact.rounded();
        }
    }

    fn begin(&mut self, block: &Block<Sparse>) {
        let m = block.muscles();
        self.held.lower[..m].copy_from_slice(block.lower);
        self.held.upper[..m].copy_from_slice(block.upper);
        // Which torque is the closest has nothing to do with weights.
        self.held.compliance[..m].fill(1.0);
        for (torque, wanted) in self.held.torque.iter_mut().zip(block.torque) {
            *torque = Twofold::from(*wanted);
        }
    }

    /// The best multipliers, from none on, with one anchor after the other until the residual is gone or stands still.
    ///
    /// The less is left of the torque, the softer the anchor: multipliers then have less far to go.
    fn settle(&mut self, block: &Block<Sparse>, steps: &mut u32) {
        let n = block.joints();
        let stiffness = self.held.stiffest(block);
        let stiffness = if stiffness > 0.0 { stiffness } else { 1.0 };
        let mut left = 1.0;
        self.held.lambda[..n].fill(Twofold::ZERO);
        self.last[..n].fill(Twofold::ZERO);
        for _ in 0..ANCHORS {
            self.held.anchor[..n].copy_from_slice(&self.held.lambda[..n]);
            self.held.ascend(block, SOFTNESS * left * stiffness, steps);
            let error =
                |j: usize| self.held.residual[j].abs().rounded() / self.held.scale[j].max(f64::MIN_POSITIVE);
            let error = (0..n).map(error).fold(0.0, f64::max);
            if error <= BALANCED || self.stands_still(block) {
                break;
            }
            left = (SOFTER * left).max(error).clamp(SOFTEST, 1.0);
            self.last[..n].copy_from_slice(&self.held.residual[..n]);
        }
    }

    /// Whether neither the residual moves nor a muscle will that it would draw from its limit.
    fn stands_still(&mut self, block: &Block<Sparse>) -> bool {
        let n = block.joints();
        for j in 0..n {
            self.doubt[j] = (self.held.residual[j] - self.last[j]).abs().rounded().max(self.held.rounding[j]);
            if self.doubt[j] > self.held.rounding[j].max(STILL * self.held.scale[j]) {
                return false;
            }
        }
        (0..block.muscles()).all(|i| match (self.held.limit[i], self.held.lower[i] < self.held.upper[i]) {
            (Limit::Lower, true) => self.wish(block, i) <= 0.0,
            (Limit::Upper, true) => self.wish(block, i) >= 0.0,
            _ => true,
        })
    }

    /// How fast the residual falls as the muscle's tension rises; zero where that is in doubt.
    fn wish(&self, block: &Block<Sparse>, muscle: usize) -> f64 {
        let wish = dot(block, muscle, &self.held.residual).rounded();
        let size = |j: usize| self.doubt[j] + CERTAIN * self.held.residual[j].rounded().abs();
        let doubt: f64 = block.rows.row(muscle).map(|(j, arm)| arm.abs() * size(j)).sum();
        if wish.abs() <= doubt { 0.0 } else { wish }
    }

    /// Asks for the closest torque in place of the wanted one. Muscles that would still lower the residual stay where
    /// they are in every answer; the choice is among the others.
    fn narrow(&mut self, block: &Block<Sparse>) {
        let n = block.joints();
        if (0..n).all(|j| self.held.residual[j].abs().rounded() <= REACHED * self.held.scale[j]) {
            return;
        }
        for i in 0..block.muscles() {
            if self.held.limit[i] != Limit::Free && self.wish(block, i) != 0.0 {
                let at =
                    if self.held.limit[i] == Limit::Lower { self.held.lower[i] } else { self.held.upper[i] };
                (self.held.lower[i], self.held.upper[i]) = (at, at);
            }
        }
        for (torque, residual) in self.held.torque[..n].iter_mut().zip(&self.held.residual) {
            *torque -= *residual;
        }
    }
}
