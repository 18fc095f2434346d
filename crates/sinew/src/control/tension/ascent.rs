//! Semismooth Newton ascent on the dual, in one unknown per joint instead of one per muscle.

use super::block::{Block, Residual, State, relative};
use super::factor::{factor, solve};
use super::line_search::{Line, Segment, room, search};
use super::problem::Limit;
use super::rows::{Rows, dot};
use super::scalar::Scalar;
use super::settings::Tolerances;
use crate::dispatch::{Arithmetic, InstructionSet, Work};
use alloc::vec::Vec;

/// Newton steps taken, and where they end.
#[derive(Debug)]
pub(super) struct Steps {
    pub(super) taken: u32,
    pub(super) limit: u32,
}

impl Steps {
    /// Whether there may be so many more.
    pub(super) fn allow(&self, more: u32) -> bool {
        self.taken.saturating_add(more) <= self.limit
    }
}

/// State of the ascent.
#[derive(Debug, Clone)]
pub(super) struct Ascent<S> {
    tolerances: Tolerances,
    pub(super) muscles: Vec<State<S>>,
    pub(super) residual: Residual<S>,
    gradient: Vec<S>,
    step: Vec<S>,
    /// Diagonal of the Newton matrix with every muscle free, and the smallest pivots.
    pub(super) diagonal: Vec<f64>,
    floor: Vec<f64>,
    /// Of every muscle in the Newton matrix: its compliance where it is free.
    weights: Vec<f64>,
    /// Factors of the Newton matrix.
    factors: Vec<S>,
    instructions: InstructionSet,
    segments: Vec<Segment<S>>,
}

/// The term `- eps/2 |lambda - center|^2` of a regularized dual.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proximal<'a, S> {
    pub(super) regularization: f64,
    pub(super) center: &'a [S],
    /// The ascent stops at gradients below this part of `|tau_j| + sum_i |R_ij F_i|`.
    pub(super) tolerance: f64,
}

impl<S: Scalar> Ascent<S> {
    pub(super) fn new(muscles: usize, joints: usize, tolerances: Tolerances) -> Self {
        Self {
            tolerances,
            muscles: alloc::vec![State::ZERO; muscles],
            residual: Residual::new(joints),
            gradient: alloc::vec![S::ZERO; joints],
            step: alloc::vec![S::ZERO; joints],
            diagonal: alloc::vec![0.0; joints],
            floor: alloc::vec![0.0; joints],
            weights: alloc::vec![0.0; muscles],
            factors: alloc::vec![S::ZERO; joints * joints],
            instructions: InstructionSet::detect_narrow(),
            segments: room(muscles),
        }
    }

    /// Maximises the dual, regularized or not, from `lambda` on; from multipliers of zero, it starts where
    /// muscles without limits would have it. False where the dual is unbounded (no tensions within the limits
    /// give the torque), or where rounding or the limit of steps ended the search.
    ///
    /// ```text
    /// D(lambda) = min_{F_min <= F <= F_max} 1/2 (F - F_ref)^T W (F - F_ref) + lambda^T (tau - R^T F)
    ///
    /// F = clip(F_ref + W^-1 R lambda, F_min, F_max)
    /// g = tau - R^T F - eps (lambda - center)                 gradient
    /// H = R_free^T W^-1 R_free + eps I                        negated element of the generalized Hessian
    /// lambda := lambda + s H^-1 g
    /// ```
    ///
    /// The dual is concave and piecewise quadratic. `s` maximises it along the step (1 where the active set
    /// does not change), so that every step ascends, no piece is visited twice, and a step that leaves the
    /// active set unchanged ends the search; steps after it remove rounding. Where the free muscles do not
    /// move every joint, `H` is singular: its factors then send the step along the null space, until a muscle
    /// becomes free or the dual is seen to be unbounded.
    ///
    /// # Source
    /// Semismooth Newton: `qi1993`; with regularization, proximal center and exact line search for quadratic
    /// programs: `hermans2019`.
    pub(super) fn maximise<R: Rows>(
        &mut self,
        block: &Block<R, S>,
        proximal: Option<Proximal<S>>,
        lambda: &mut [S],
        steps: &mut Steps,
    ) -> bool {
        let n = block.rows.joints();
        self.set_floor(block);
        let possible = proximal.is_none() && n > 0 && steps.allow(1);
        if possible && lambda.iter().all(|lambda| lambda.rounded() == 0.0) {
            self.start(block, lambda);
            steps.taken += 1;
        }
        self.evaluate(block, lambda);
        let (mut active_set_unchanged, mut last) = (false, f64::INFINITY);
        let tolerance = proximal.map_or(self.tolerances.residual, |proximal| proximal.tolerance);
        // As a rule, each step settles at least one muscle.
        for _ in 0..20 + 2 * (block.muscles.len() + n) {
            if !steps.allow(1) {
                break;
            }
            self.gradient[..n].copy_from_slice(&self.residual.torque[..n]);
            if let Some(Proximal { regularization, center, .. }) = proximal {
                for ((gradient, lambda), center) in self.gradient.iter_mut().zip(&*lambda).zip(center) {
                    *gradient = *gradient - (*lambda - *center) * S::from(regularization);
                }
            }
            let error = relative(&self.gradient[..n], &self.residual.scale);
            if error <= tolerance {
                return true;
            }
            // The last step should have ended it, and the one before as well.
            if active_set_unchanged && error > 0.5 * last {
                break;
            }
            if !active_set_unchanged {
                self.factor(block, proximal);
            }
            self.step[..n].copy_from_slice(&self.gradient[..n]);
            solve(&self.factors[..n * n], &mut self.step[..n]);
            steps.taken += 1;
            active_set_unchanged = self.try_full_step(block);
            let length = if active_set_unchanged { S::from(1.0) } else { self.line_search(block, proximal) };
            // Along a null space, a residual of rounding leads far away.
            let far = length.rounded() > 2.0 && error <= 50.0 * self.tolerances.residual;
            if far && proximal.is_none() || length.rounded() == f64::INFINITY {
                break;
            }
            for (lambda, step) in lambda.iter_mut().zip(&self.step) {
                *lambda = *lambda + length * *step;
            }
            last = error;
            if !active_set_unchanged {
                self.evaluate(block, lambda);
                continue;
            }
            // The last tensions and the step keep what large multipliers round away.
            for (state, muscle) in self.muscles.iter_mut().zip(block.muscles) {
                state.unclipped = state.unclipped + state.rate;
                state.clip(muscle);
            }
            self.measure(block);
            if proximal.is_some() {
                return true;
            }
        }
        // Tensions of this form cost least for the torque that they give, which may be the desired one.
        proximal.is_none()
            && relative(&self.residual.torque[..n], &self.residual.scale) <= 50.0 * self.tolerances.residual
    }

    /// The residual of the tensions.
    pub(super) fn measure<R: Rows>(&mut self, block: &Block<R, S>) {
        let tensions = self.muscles[..block.muscles.len()].iter().map(|state| state.tension);
        self.residual.measure(block, tensions);
    }

    /// Sets the diagonal of the Newton matrix with every muscle free, and the smallest pivots; the largest
    /// entry, or 1 where there is none.
    pub(super) fn set_floor<R: Rows, T>(&mut self, block: &Block<R, T>) -> f64 {
        let n = block.rows.joints();
        let pivot = 10.0 * self.tolerances.rounding;
        self.diagonal[..n].fill(0.0);
        for (i, muscle) in block.muscles.iter().enumerate() {
            let add = |diagonal: &mut f64, arm| *diagonal += muscle.compliance * arm * arm;
            block.rows.change(i, &mut self.diagonal, add);
        }
        for (floor, diagonal) in self.floor[..n].iter_mut().zip(&self.diagonal) {
            // No muscle crosses the joint, or its arms vanish in this pose.
            *floor = if *diagonal > 0.0 { pivot * diagonal } else { 1.0 };
        }
        let most = self.diagonal[..n].iter().copied().fold(0.0, f64::max);
        if most > 0.0 { most } else { 1.0 }
    }

    /// The multipliers that muscles without limits would have.
    fn start<R: Rows>(&mut self, block: &Block<R, S>, lambda: &mut [S]) {
        let n = block.rows.joints();
        self.residual.measure(block, block.muscles.iter().map(|muscle| S::from(muscle.reference)));
        lambda.copy_from_slice(&self.residual.torque[..n]);
        for (weight, muscle) in self.weights.iter_mut().zip(block.muscles) {
            *weight = muscle.compliance;
        }
        self.factor_weighed(block, S::ZERO);
        solve(&self.factors[..n * n], lambda);
    }

    /// Tensions, limits and residual at `lambda`.
    fn evaluate<R: Rows>(&mut self, block: &Block<R, S>, lambda: &[S]) {
        for (i, (state, muscle)) in self.muscles.iter_mut().zip(block.muscles).enumerate() {
            let rate = block.rows.dot(i, lambda) * S::from(muscle.compliance);
            state.unclipped = S::from(muscle.reference) + rate;
            state.limit = Limit::new(state.unclipped, muscle.lower, muscle.upper);
            state.clip(muscle);
        }
        self.measure(block);
    }

    /// Factors of the Newton matrix of the active set.
    fn factor<R: Rows>(&mut self, block: &Block<R, S>, proximal: Option<Proximal<S>>) {
        let states = self.muscles.iter().zip(block.muscles);
        for (weight, (state, muscle)) in self.weights.iter_mut().zip(states) {
            *weight = if state.limit == Limit::Free { muscle.compliance } else { 0.0 };
        }
        let regularization = proximal.map_or(0.0, |proximal| proximal.regularization);
        self.factor_weighed(block, S::from(regularization));
    }

    /// The same with the weights as they are.
    fn factor_weighed<R: Rows>(&mut self, block: &Block<R, S>, regularization: S) {
        let (m, n) = (block.muscles.len(), block.rows.joints());
        let Self { weights, factors, floor, instructions, .. } = self;
        let (weights, factors, floor) = (&weights[..m], &mut factors[..n * n], &floor[..n]);
        let newton = Newton { rows: block.rows, weights, regularization, factors, floor };
        // Three joints and fewer have nothing to do at once.
        if n > 3 { instructions.run(newton) } else { InstructionSet::Baseline.run(newton) }
    }

    /// What the full step does to every muscle; whether it leaves the active set unchanged.
    fn try_full_step<R: Rows>(&mut self, block: &Block<R, S>) -> bool {
        let mut unchanged = true;
        for (i, (state, muscle)) in self.muscles.iter_mut().zip(block.muscles).enumerate() {
            state.pull = block.rows.dot(i, &self.step);
            state.rate = state.pull * S::from(muscle.compliance);
            unchanged &= Limit::new(state.unclipped + state.rate, muscle.lower, muscle.upper) == state.limit;
        }
        unchanged
    }

    /// Length of the step that maximises the dual; infinite if it rises without bound.
    fn line_search<R: Rows>(&mut self, block: &Block<R, S>, proximal: Option<Proximal<S>>) -> S {
        let n = block.rows.joints();
        let step = &self.step[..n];
        let regularization = proximal.map_or(0.0, |proximal| proximal.regularization);
        let line = Line {
            slope: dot(step, &self.gradient[..n]),
            torque: dot(step, block.torque).rounded().abs(),
            regularization: dot(step, step) * S::from(regularization),
        };
        search(self.muscles.iter().zip(block.muscles), &line, self.tolerances.rounding, &mut self.segments)
    }
}

/// Factors of the Newton matrix with these weights.
struct Newton<'a, R, S> {
    rows: R,
    weights: &'a [f64],
    regularization: S,
    factors: &'a mut [S],
    floor: &'a [f64],
}

impl<R: Rows, S: Scalar> Work for Newton<'_, R, S> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        let Self { rows, weights, regularization, factors, floor } = self;
        rows.weigh(weights, factors);
        for k in 0..floor.len() {
            let pivot = &mut factors[k * floor.len() + k];
            *pivot = *pivot + regularization;
        }
        factor(factors, floor);
    }
}
