//! The method: ascent of the dual, the closest torque where that is unbounded, and both again in twice the
//! digits.

use super::ascent::{Ascent, Point, Proximal};
use super::certificate::certify;
use super::closest::Closest;
use super::rows::{Block, Rows, Sparse};
use super::scalar::{DoubleDouble, Scalar};
use super::settings::Settings;
use super::solution::Status;
use alloc::vec::Vec;

/// Solves one group of joints after the other.
#[derive(Debug, Clone)]
pub(super) struct Solver {
    settings: Settings,
    double: Search<f64>,
    double_double: Search<DoubleDouble>,
    torque: Vec<DoubleDouble>,
    lambda: Vec<DoubleDouble>,
    regularized: Vec<DoubleDouble>,
}

/// Multipliers of a group's last solution, where the next search starts; those of the new one.
#[derive(Debug)]
pub(super) struct GroupStart<'a> {
    pub(super) lambda: &'a mut [f64],
    /// Multipliers of the regularized dual, and whether they are those of the last solution.
    pub(super) regularized: &'a mut [f64],
    pub(super) infeasible: &'a mut bool,
}

impl Solver {
    pub(super) fn new(muscles: usize, joints: usize, settings: &Settings) -> Self {
        Self {
            settings: *settings,
            double: Search::new(muscles, joints, settings),
            double_double: Search::new(muscles, joints, settings),
            torque: alloc::vec![DoubleDouble::ZERO; joints],
            lambda: alloc::vec![DoubleDouble::ZERO; joints],
            regularized: alloc::vec![DoubleDouble::ZERO; joints],
        }
    }

    /// Tensions and residual of the group solved last.
    pub(super) fn result(&self) -> (&[f64], &[f64]) {
        (&self.double.ascent.here.tension, &self.double.ascent.here.residual)
    }

    /// Tensions, multipliers and status of a group whose arms are also given as `rows` of another layout.
    pub(super) fn solve<R: Rows>(
        &mut self,
        block: &Block<Sparse, f64>,
        rows: R,
        start: &mut GroupStart,
        steps: &mut u32,
    ) -> Status {
        let fast = block.with(rows, block.torque);
        let converged =
            self.solve_double(&fast, start, steps) || self.solve_double_double(block, start.lambda, steps);
        let Point { residual, scale, .. } = &self.double.ascent.here;
        if converged {
            return certify(&fast, residual, scale, &self.settings);
        }
        if !start.lambda.iter().all(|lambda| lambda.is_finite()) {
            start.lambda.fill(0.0);
        }
        Status::NotConverged
    }

    /// The search in `f64`. Where the last torque was out of reach, the next one likely is.
    fn solve_double<R: Rows>(
        &mut self,
        block: &Block<R, f64>,
        start: &mut GroupStart,
        steps: &mut u32,
    ) -> bool {
        let GroupStart { lambda, regularized, infeasible } = start;
        if **infeasible && self.double.approach(block, lambda, regularized, steps) {
            return true;
        }
        **infeasible = false;
        if self.double.reach(block, lambda, steps) {
            return true;
        }
        regularized.copy_from_slice(lambda);
        **infeasible = self.double.approach(block, lambda, regularized, steps);
        **infeasible
    }

    /// The search in twice the digits, from nothing.
    #[cold]
    fn solve_double_double(
        &mut self,
        block: &Block<Sparse, f64>,
        lambda: &mut [f64],
        steps: &mut u32,
    ) -> bool {
        let (m, n) = (block.muscles(), block.joints());
        for (torque, desired) in self.torque.iter_mut().zip(block.torque) {
            *torque = DoubleDouble::from(*desired);
        }
        let extended_block = block.with(block.rows, &self.torque[..n]);
        let (extended, regularized) = (&mut self.lambda[..n], &mut self.regularized[..n]);
        extended.fill(DoubleDouble::ZERO);
        regularized.fill(DoubleDouble::ZERO);
        let search = &mut self.double_double;
        let converged = search.approach(&extended_block, extended, regularized, steps);
        let tension = self.double.ascent.here.tension[..m].iter_mut();
        tension
            .zip(&search.ascent.here.tension)
            .for_each(|(tension, extended)| *tension = extended.rounded());
        for (lambda, extended) in lambda.iter_mut().zip(extended) {
            *lambda = extended.rounded();
        }
        self.double.ascent.here.measure(block);
        converged
    }
}

/// The search in one precision.
#[derive(Debug, Clone)]
struct Search<S> {
    settings: Settings,
    ascent: Ascent<S>,
    closest: Closest<S>,
    center: Vec<S>,
}

impl<S: Scalar> Search<S> {
    fn new(muscles: usize, joints: usize, settings: &Settings) -> Self {
        Self {
            settings: *settings,
            ascent: Ascent::new(muscles, joints, settings),
            closest: Closest::new(muscles, joints, settings),
            center: alloc::vec![S::ZERO; joints],
        }
    }

    /// Tensions that give the torque at least cost, from `lambda` on; false where there are none or rounding
    /// hides them.
    fn reach<R: Rows>(&mut self, block: &Block<R, S>, lambda: &mut [S], steps: &mut u32) -> bool {
        let limit = self.limit(block, *steps);
        self.ascent.maximise(block, None, lambda, limit, steps) && self.ascent.is_accurate(lambda)
    }

    /// Tensions that give the closest torque, at least cost among those that do; false where rounding hides
    /// them.
    ///
    /// ```text
    /// max_lambda  D(lambda) - eps/2 |lambda - center|^2           center := lambda, and again
    /// ```
    ///
    /// The proximal-point method on the dual, which is the augmented Lagrangian method on the problem: it
    /// goes to the closest torque `tau - r`, and its multipliers grow by `r / eps` each time. As soon as its
    /// active set proves to be that of the closest torque, what remains is a problem within reach.
    /// `regularized` holds the multipliers to start from and receives the last, as a start for the next tick.
    ///
    /// # Source
    /// `chiche2014` for augmented Lagrangians of infeasible problems.
    fn approach<R: Rows>(
        &mut self,
        block: &Block<R, S>,
        lambda: &mut [S],
        regularized: &mut [S],
        steps: &mut u32,
    ) -> bool {
        let (m, n) = (block.muscles(), block.joints());
        let tolerances = *S::tolerances(&self.settings);
        self.ascent.set_floor(block);
        let diagonal = self.ascent.largest_diagonal(n);
        let diagonal = if diagonal > 0.0 { diagonal } else { 1.0 };
        let [first, least, ratio] = tolerances.regularization;
        let (mut relative, mut growth) = (first, 0.0);
        self.center[..n].fill(S::ZERO);
        for _ in 0..tolerances.proximal_steps {
            let regularization = relative * diagonal;
            relative = least.max(ratio * relative);
            growth += 1.0 / regularization;
            let limit = self.limit(block, *steps);
            let proximal = Proximal { regularization, center: &self.center[..n] };
            if !self.ascent.maximise(block, Some(proximal), regularized, limit, steps) {
                return false;
            }
            if self.ascent.here.error(n) <= self.settings.residual && self.ascent.is_accurate(regularized) {
                lambda.copy_from_slice(regularized);
                return true;
            }
            if self.closest.reduce(block, &self.ascent.limit[..m]) {
                // Without the part that grows with every proximal step.
                for ((lambda, regularized), left) in
                    lambda.iter_mut().zip(&*regularized).zip(&self.closest.residual)
                {
                    *lambda = *regularized - *left * growth;
                }
                let reduced = self.closest.reduced(block);
                let limit = self.limit(block, *steps);
                if self.ascent.maximise(&reduced, None, lambda, limit, steps)
                    && self.ascent.is_accurate(lambda)
                {
                    self.ascent.here.measure(block);
                    return true;
                }
            }
            self.center[..n].copy_from_slice(regularized);
        }
        false
    }

    /// Steps allowed in one ascent: as a rule, each settles at least one muscle.
    fn limit<R: Rows>(&self, block: &Block<R, S>, taken: u32) -> u32 {
        let usual = 20 + u32::try_from(2 * (block.muscles() + block.joints())).unwrap_or(u32::MAX / 2);
        usual.min(self.settings.max_iterations.saturating_sub(taken))
    }
}
