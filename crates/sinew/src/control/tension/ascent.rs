//! Semismooth Newton ascent on the dual, in one unknown per joint instead of one per muscle.

use super::factor::{factor, solve};
use super::line_search::{Line, Ray, Segment, room, search};
use super::problem::Limit;
use super::rows::{Block, Rows, dot, relative_residual};
use super::scalar::Scalar;
use super::settings::{Settings, Tolerances};
use alloc::vec::Vec;

/// Tensions and residual for some multipliers.
#[derive(Debug, Clone)]
pub(super) struct Point<S> {
    /// `F_ref + W^-1 R lambda`, and `F`, which is that within the limits.
    unclipped: Vec<S>,
    pub(super) tension: Vec<S>,
    /// `tau - R^T F`, and `|tau_j| + sum_i |R_ij F_i|`.
    pub(super) residual: Vec<S>,
    pub(super) scale: Vec<f64>,
}

impl<S: Scalar> Point<S> {
    fn new(muscles: usize, joints: usize) -> Self {
        Self {
            unclipped: alloc::vec![S::ZERO; muscles],
            tension: alloc::vec![S::ZERO; muscles],
            residual: alloc::vec![S::ZERO; joints],
            scale: alloc::vec![0.0; joints],
        }
    }

    /// The residual of its tensions.
    #[inline(always)]
    pub(super) fn measure<R: Rows>(&mut self, block: &Block<R, S>) {
        let n = block.joints();
        let (residual, scale) = (&mut self.residual[..n], &mut self.scale[..n]);
        for j in 0..n {
            residual[j] = block.torque[j];
            scale[j] = block.torque[j].rounded().abs();
        }
        block.rows.subtract_torque(&self.tension[..block.muscles()], residual, scale);
    }

    /// Largest residual relative to the magnitudes of its terms.
    #[inline(always)]
    pub(super) fn error(&self, joints: usize) -> f64 {
        relative_residual(&self.residual[..joints], &self.scale[..joints])
    }
}

/// Newton steps taken, what each of them costs, and where they end.
#[derive(Debug)]
pub(super) struct Steps {
    pub(super) taken: u32,
    pub(super) limit: u32,
    /// Multiplications in a step, and those allowed.
    pub(super) operations: u64,
    pub(super) budget: u64,
}

impl Steps {
    /// Multiplications of all steps so far.
    pub(super) fn spent(&self) -> u64 {
        u64::from(self.taken) * self.operations
    }

    /// Whether there may be so many more.
    pub(super) fn allow(&self, more: u32) -> bool {
        self.taken.saturating_add(more) <= self.limit
            && self.spent() + u64::from(more) * self.operations <= self.budget
    }
}

/// State of the ascent.
#[derive(Debug, Clone)]
pub(super) struct Ascent<S> {
    settings: Settings,
    tolerances: Tolerances,
    /// At the multipliers, and after a full step.
    pub(super) here: Point<S>,
    ahead: Point<S>,
    // Per muscle: its limit, `R_i d` and `R_i d / w_i`, where `d` is the step.
    pub(super) limit: Vec<Limit>,
    pull: Vec<S>,
    rate: Vec<S>,
    segments: Vec<Segment<S>>,
    // Per joint.
    step: Vec<S>,
    /// Diagonal of the Newton matrix with every muscle free, and the smallest pivots.
    diagonal: Vec<f64>,
    floor: Vec<f64>,
    /// Factors of the Newton matrix.
    factors: Vec<S>,
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
    pub(super) fn new(muscles: usize, joints: usize, settings: &Settings, tolerances: Tolerances) -> Self {
        Self {
            settings: *settings,
            tolerances,
            here: Point::new(muscles, joints),
            ahead: Point::new(muscles, joints),
            limit: alloc::vec![Limit::Free; muscles],
            pull: alloc::vec![S::ZERO; muscles],
            rate: alloc::vec![S::ZERO; muscles],
            segments: room(muscles),
            step: alloc::vec![S::ZERO; joints],
            diagonal: alloc::vec![0.0; joints],
            floor: alloc::vec![0.0; joints],
            factors: alloc::vec![S::ZERO; joints * joints],
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
        let n = block.joints();
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
        for _ in 0..20 + 2 * (block.muscles() + n) {
            if !steps.allow(1) {
                break;
            }
            self.set_gradient(n, lambda, proximal);
            let error = relative_residual(&self.step[..n], &self.here.scale[..n]);
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
            solve(&self.factors[..n * n], &mut self.step[..n]);
            steps.taken += 1;
            active_set_unchanged = self.try_full_step(block);
            let length =
                if active_set_unchanged { S::from(1.0) } else { self.line_search(block, lambda, proximal) };
            // Along a null space, a residual of rounding leads far away.
            if proximal.is_none() && length.rounded() > 2.0 && error <= 50.0 * self.tolerances.residual {
                return true;
            }
            if length.rounded() == f64::INFINITY {
                break;
            }
            for (lambda, step) in lambda.iter_mut().zip(&self.step) {
                *lambda += length * *step;
            }
            last = error;
            if !active_set_unchanged {
                self.evaluate(block, lambda);
                continue;
            }
            // The last tensions and the step keep what large multipliers round away.
            core::mem::swap(&mut self.here, &mut self.ahead);
            if proximal.is_some() {
                return true;
            }
        }
        // Tensions of this form cost least for the torque that they give, which may be the desired one.
        proximal.is_none() && self.here.error(n) <= 50.0 * self.tolerances.residual
    }

    /// Whether multipliers are small enough for the tensions that are sums of their terms: where joints are
    /// hard to tell apart, large ones cancel and leave rounding in the tensions.
    ///
    /// ```text
    /// H_jj sum_k H_kk lambda_k^2 <= c^2 (|tau_j| + sum_i |R_ij F_i|)^2,     H = R^T W^-1 R
    /// ```
    pub(super) fn is_accurate(&self, lambda: &[S]) -> bool {
        let bound = self.settings.cancellation / self.tolerances.rounding;
        let terms =
            self.diagonal.iter().zip(lambda).map(|(h, lambda)| h * lambda.rounded() * lambda.rounded());
        let energy: f64 = terms.sum();
        let mut joints = self.diagonal.iter().zip(&self.here.scale[..lambda.len()]);
        joints.all(|(h, scale)| *scale == 0.0 || h * energy <= bound * bound * scale * scale)
    }

    /// Sets the diagonal of the Newton matrix with every muscle free, and the smallest pivots; the largest entry,
    /// or 1 where there is none.
    pub(super) fn set_floor<R: Rows, T>(&mut self, block: &Block<R, T>) -> f64 {
        let n = block.joints();
        let pivot = 10.0 * self.tolerances.rounding;
        self.diagonal[..n].fill(0.0);
        for (muscle, compliance) in block.compliance.iter().enumerate() {
            for (joint, arm) in block.rows.row(muscle) {
                self.diagonal[joint] += compliance * arm * arm;
            }
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
        let n = block.joints();
        for (tension, reference) in self.here.tension.iter_mut().zip(block.reference) {
            *tension = S::from(*reference);
        }
        self.here.measure(block);
        lambda.copy_from_slice(&self.here.residual[..n]);
        let factors = &mut self.factors[..n * n];
        block.rows.weigh(block.compliance.iter().copied(), factors);
        factor(factors, &self.floor[..n]);
        solve(factors, lambda);
    }

    /// Tensions, limits and residual at `lambda`.
    #[inline(always)]
    fn evaluate<R: Rows>(&mut self, block: &Block<R, S>, lambda: &[S]) {
        let m = block.muscles();
        let (unclipped, tension) = (&mut self.here.unclipped[..m], &mut self.here.tension[..m]);
        let (limit, lower, upper) = (&mut self.limit[..m], &block.lower[..m], &block.upper[..m]);
        let (reference, compliance) = (&block.reference[..m], &block.compliance[..m]);
        for i in 0..m {
            unclipped[i] = S::from(reference[i]) + block.rows.dot(i, lambda) * S::from(compliance[i]);
            limit[i] = Limit::of(unclipped[i], lower[i], upper[i]);
            tension[i] = clip(unclipped[i], lower[i], upper[i]);
        }
        self.here.measure(block);
    }

    /// Factors of the Newton matrix of the active set.
    #[inline(always)]
    fn factor<R: Rows>(&mut self, block: &Block<R, S>, proximal: Option<Proximal<S>>) {
        let n = block.joints();
        let factors = &mut self.factors[..n * n];
        let free = self.limit.iter().zip(block.compliance);
        let weights = free.map(|(limit, compliance)| if *limit == Limit::Free { *compliance } else { 0.0 });
        block.rows.weigh(weights, factors);
        if let Some(Proximal { regularization, .. }) = proximal {
            factors.iter_mut().step_by(n + 1).for_each(|pivot| *pivot += S::from(regularization));
        }
        factor(factors, &self.floor[..n]);
    }

    /// Puts the gradient where the step will be.
    #[inline(always)]
    fn set_gradient(&mut self, joints: usize, lambda: &[S], proximal: Option<Proximal<S>>) {
        let gradient = &mut self.step[..joints];
        gradient.copy_from_slice(&self.here.residual[..joints]);
        if let Some(Proximal { regularization, center, .. }) = proximal {
            for ((gradient, lambda), center) in gradient.iter_mut().zip(lambda).zip(center) {
                *gradient -= (*lambda - *center) * S::from(regularization);
            }
        }
    }

    /// What the full step does to every muscle, and where it leads if it leaves the active set unchanged,
    /// which is returned.
    #[inline(always)]
    fn try_full_step<R: Rows>(&mut self, block: &Block<R, S>) -> bool {
        let m = block.muscles();
        let (pull, rate) = (&mut self.pull[..m], &mut self.rate[..m]);
        let (here, limit) = (&self.here.unclipped[..m], &self.limit[..m]);
        let (unclipped, tension) = (&mut self.ahead.unclipped[..m], &mut self.ahead.tension[..m]);
        let (lower, upper, compliance) = (&block.lower[..m], &block.upper[..m], &block.compliance[..m]);
        let mut unchanged = true;
        for i in 0..m {
            pull[i] = block.rows.dot(i, &self.step);
            rate[i] = pull[i] * S::from(compliance[i]);
            unclipped[i] = here[i] + rate[i];
            tension[i] = clip(unclipped[i], lower[i], upper[i]);
            unchanged &= Limit::of(unclipped[i], lower[i], upper[i]) == limit[i];
        }
        if unchanged {
            self.ahead.measure(block);
        }
        unchanged
    }

    /// Length of the step that maximises the dual; infinite if it rises without bound.
    #[inline(always)]
    fn line_search<R: Rows>(
        &mut self,
        block: &Block<R, S>,
        lambda: &[S],
        proximal: Option<Proximal<S>>,
    ) -> S {
        let (m, n) = (block.muscles(), block.joints());
        let step = &self.step[..n];
        let mut line = Line {
            slope: dot(step, &self.here.residual[..n]),
            torque: dot(step, &block.torque[..n]).rounded().abs(),
            regularization: S::ZERO,
        };
        if let Some(Proximal { regularization, center, .. }) = proximal {
            for ((step, lambda), center) in step.iter().zip(lambda).zip(center) {
                line.slope -= *step * (*lambda - *center) * S::from(regularization);
                line.regularization += *step * *step * S::from(regularization);
            }
        }
        let (unclipped, pull, rate) = (&self.here.unclipped[..m], &self.pull[..m], &self.rate[..m]);
        let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
        let rays = (0..m).map(|i| Ray {
            from: unclipped[i],
            lower: lower[i],
            upper: upper[i],
            pull: pull[i],
            rate: rate[i],
        });
        search(rays, &line, self.tolerances.rounding, &mut self.segments)
    }
}

/// The tension within its limits that is nearest; the limit's own bits where one holds.
#[inline(always)]
fn clip<S: Scalar>(unclipped: S, lower: f64, upper: f64) -> S {
    let (lower, upper) = (S::from(lower), S::from(upper));
    let tension = if unclipped > lower { unclipped } else { lower };
    if tension < upper { tension } else { upper }
}
