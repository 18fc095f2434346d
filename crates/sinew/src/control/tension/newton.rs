//! Newton's method in the few unknowns of the dual: one multiplier per joint instead of one tension per muscle.

use super::block::{Block, Limit};
use super::factor::{factor, solve};
use super::line_search::{Event, Ray, Reach, room, search};
use super::pattern::places;
use super::rows::Rows;
use alloc::vec::Vec;

/// What the steps work in.
#[derive(Debug, Clone)]
pub(super) struct Work {
    /// Per muscle: tension, tension without limits, its change along the step, what the step does to the muscle.
    pub(super) tension: Vec<f64>,
    wanted: Vec<f64>,
    rate: Vec<f64>,
    pull: Vec<f64>,
    pub(super) limit: Vec<Limit>,
    /// Per joint: what is left of the torque, what it is made of, the step, the smallest pivot.
    pub(super) residual: Vec<f64>,
    scale: Vec<f64>,
    step: Vec<f64>,
    floor: Vec<f64>,
    hessian: Vec<f64>,
    /// Muscles between their limits, with their compliance.
    free: Vec<(usize, f64)>,
    events: Vec<Event>,
}

/// How the method ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The torque is reached, at least cost.
    Reached,
    /// No tensions within the limits give the torque.
    Unreachable,
    /// The steps ran out.
    Exhausted,
}

/// Pivots relative to the stiffness of all muscles together: below it, the free muscles do not move the joint.
const LEAST_PIVOT: f64 = 1e-13;

/// Residual relative to what it is made of: a few units in the last place of a sum.
const BALANCED: f64 = 2e-15;

/// Along a null space, a residual of rounding leads far away: step length and residual that tell it.
const FAR: f64 = 2.0;
const NOISE: f64 = 1e-12;

/// What a residual that repeating the last step does not lower may be.
const STALLED: f64 = 1e-9;

impl Work {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let joints = places(joints);
        Self {
            tension: alloc::vec![0.0; muscles],
            wanted: alloc::vec![0.0; muscles],
            rate: alloc::vec![0.0; muscles],
            pull: alloc::vec![0.0; muscles],
            limit: alloc::vec![Limit::Free; muscles],
            residual: alloc::vec![0.0; joints],
            scale: alloc::vec![0.0; joints],
            step: alloc::vec![0.0; joints],
            floor: alloc::vec![0.0; joints],
            hessian: alloc::vec![0.0; joints * joints],
            free: Vec::with_capacity(muscles),
            events: room(muscles),
        }
    }

    /// Maximises the dual from `lambda` on; adds the number of steps to `steps`.
    ///
    /// ```text
    /// F = clip(F_ref + W^-1 R lambda, F_min, F_max)          g = tau - R^T F          (gradient of the dual)
    /// H = R_free^T W^-1 R_free                               lambda := lambda + s H^-1 g
    /// ```
    ///
    /// The dual is concave and piecewise quadratic. `s` is its exact maximum along the step (1 where no muscle meets or
    /// leaves a limit), so every step ascends, a piece is left for good, and a step within a piece ends the search:
    /// what follows it only removes rounding. `H` has full rank only if the free muscles move every joint; elsewhere
    /// its factors send the step along the null space until a muscle comes free, or show that none ever does.
    pub(super) fn solve<R: Rows>(
        &mut self,
        block: &Block<R>,
        lambda: &mut [f64],
        most: u32,
        steps: &mut u32,
    ) -> Outcome {
        let n = block.joints();
        self.set_floor(block);
        self.evaluate(block, lambda);
        let (mut factored, mut settled, mut last) = (false, false, f64::INFINITY);
        for _ in 0..most {
            let error = self.error(n);
            if error <= BALANCED || (settled && error > 0.5 * last && error <= STALLED) {
                return Outcome::Reached;
            }
            if !factored {
                self.factor(block);
            }
            *steps += 1;
            self.step[..n].copy_from_slice(&self.residual[..n]);
            solve(&self.hessian[..n * n], &mut self.step[..n]);
            settled = self.look_ahead(block);
            let length = if settled { 1.0 } else { self.length(block) };
            if length > FAR && error <= NOISE {
                return Outcome::Reached;
            }
            if length == f64::INFINITY {
                return Outcome::Unreachable;
            }
            for (lambda, step) in lambda.iter_mut().zip(&self.step) {
                *lambda += length * step;
            }
            last = error;
            factored = !self.evaluate(block, lambda);
        }
        Outcome::Exhausted
    }

    /// Smallest pivots: a fraction of the stiffness with every muscle free.
    fn set_floor<R: Rows>(&mut self, block: &Block<R>) {
        let floor = &mut self.floor[..block.joints()];
        floor.fill(0.0);
        for muscle in 0..block.muscles() {
            for (joint, arm) in block.rows.row(muscle) {
                floor[joint] += LEAST_PIVOT * block.compliance[muscle] * arm * arm;
            }
        }
        // A joint that no muscle crosses, or whose arms vanished in this pose.
        floor.iter_mut().filter(|floor| **floor <= 0.0).for_each(|floor| *floor = 1.0);
    }

    /// Tensions, limits and residual at `lambda`; whether a muscle met or left a limit.
    fn evaluate<R: Rows>(&mut self, block: &Block<R>, lambda: &[f64]) -> bool {
        let mut changed = false;
        for i in 0..block.muscles() {
            let wanted = block.reference[i] + block.compliance[i] * block.rows.dot(i, lambda);
            let (lower, upper) = (block.lower[i], block.upper[i]);
            let limit = Limit::of(wanted, lower, upper);
            self.wanted[i] = wanted;
            self.tension[i] = wanted.max(lower).min(upper);
            changed |= limit != self.limit[i];
            self.limit[i] = limit;
        }
        self.measure(block);
        changed
    }

    /// What the tensions leave of the torque.
    pub(super) fn measure<R: Rows>(&mut self, block: &Block<R>) {
        block.residual(&self.tension, &mut self.residual, &mut self.scale);
    }

    /// Largest residual relative to what it is made of.
    pub(super) fn error(&self, joints: usize) -> f64 {
        let ratio = |(r, s): (&f64, &f64)| if *r == 0.0 { 0.0 } else { r.abs() / s };
        self.residual[..joints].iter().zip(&self.scale).map(ratio).fold(0.0, f64::max)
    }

    /// Factors of the stiffness that the free muscles give the joints.
    fn factor<R: Rows>(&mut self, block: &Block<R>) {
        let n = block.joints();
        let hessian = &mut self.hessian[..n * n];
        hessian.fill(0.0);
        self.free.clear();
        let free = (0..block.muscles()).filter(|&i| self.limit[i] == Limit::Free);
        self.free.extend(free.map(|i| (i, block.compliance[i])));
        block.rows.stiffen(&self.free, hessian);
        factor(hessian, &self.floor[..n]);
    }

    /// What the full step does to every muscle; whether none meets or leaves a limit.
    fn look_ahead<R: Rows>(&mut self, block: &Block<R>) -> bool {
        let mut same = true;
        for i in 0..block.muscles() {
            self.pull[i] = block.rows.dot(i, &self.step);
            self.rate[i] = block.compliance[i] * self.pull[i];
            same &= Limit::of(self.wanted[i] + self.rate[i], block.lower[i], block.upper[i]) == self.limit[i];
        }
        same
    }

    /// Length of the step that maximises the dual; infinite if it rises for ever.
    fn length<R: Rows>(&mut self, block: &Block<R>) -> f64 {
        let (m, n) = (block.muscles(), block.joints());
        let along = |x: &[f64]| -> f64 { x[..n].iter().zip(&self.step).map(|(x, step)| x * step).sum() };
        let (slope, torque) = (along(&self.residual), along(block.torque));
        let rays = (0..m).map(|i| Ray {
            from: self.wanted[i],
            lower: block.lower[i],
            upper: block.upper[i],
            rate: self.rate[i],
            pull: self.pull[i],
        });
        match search(rays, slope, torque, &mut self.events) {
            Reach::Step(length) => length,
            Reach::Unbounded => f64::INFINITY,
        }
    }
}
