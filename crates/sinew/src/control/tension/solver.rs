//! The method: ascent of the dual, the closest torque where that is unbounded, and the latter again in
//! numbers with more digits where rounding prevents a proof.

use super::ascent::{Ascent, Proximal, Steps};
use super::block::{Block, Muscle, Residual, relative};
use super::problem::Limit;
use super::rows::{Rows, Sparse, dot};
use super::scalar::{Scalar, Wide};
use super::settings::{Settings, Tolerances};
use super::solution::Status;
use alloc::vec::Vec;

/// Solves one group of joints after the other.
#[derive(Debug, Clone)]
pub(super) struct Solver {
    settings: Settings,
    double: Search<f64>,
    wide: Search<Wide>,
}

/// Newton steps without which the search in more digits, which starts from nothing, ends nowhere: one that
/// finds the closest torque and one that confirms it, and both again for the tensions that give it.
const MIN_WIDE_STEPS: u32 = 4;

/// Multipliers of a group's last solution, where the next search starts; those of the new one.
#[derive(Debug)]
pub(super) struct Start<'a> {
    pub(super) lambda: &'a mut [f64],
    /// Multipliers of the regularized dual, and whether they are those of the last solution.
    pub(super) regularized: &'a mut [f64],
    pub(super) infeasible: &'a mut bool,
}

impl Solver {
    pub(super) fn new(muscles: usize, joints: usize, settings: &Settings) -> Self {
        Self {
            settings: *settings,
            double: Search::new(muscles, joints, settings, settings.double),
            wide: Search::new(muscles, joints, settings, settings.wide),
        }
    }

    /// Drops the closest torques of earlier problems, which certify later ones.
    pub(super) fn forget(&mut self) {
        self.double.closest.fill(0.0);
        self.wide.closest.fill(Wide::ZERO);
    }

    /// Tensions and residual of the group solved last.
    pub(super) fn answer(&self) -> &Ascent<f64> {
        &self.double.ascent
    }

    /// Status and Newton steps of a group whose arms are also given as `rows` of another layout, and one of
    /// whose steps takes so many `operations`.
    pub(super) fn solve<R: Rows>(
        &mut self,
        block: &Block<Sparse, f64>,
        rows: R,
        start: &mut Start,
        operations: u64,
    ) -> (Status, u32) {
        let fast = Block { rows, muscles: block.muscles, torque: block.torque };
        let Settings { max_iterations, max_operations, .. } = self.settings;
        let most = |all: u64| u32::try_from(all / operations.max(1)).unwrap_or(u32::MAX);
        let steps = &mut Steps { taken: 0, limit: max_iterations.min(most(max_operations)) };
        let mut status = self.solve_f64(&fast, start, steps);
        steps.limit = max_iterations.min(steps.taken.saturating_add(most(max_operations / 100)));
        if status == Status::NotConverged && steps.allow(MIN_WIDE_STEPS) {
            status = self.solve_wide(block, start.lambda, steps);
        }
        if status == Status::NotConverged && !start.lambda.iter().all(|lambda| lambda.is_finite()) {
            start.lambda.fill(0.0);
        }
        (status, steps.taken)
    }

    /// The search in `f64`. Where the last torque was out of reach, the next one likely is.
    fn solve_f64(&mut self, block: &Block<impl Rows, f64>, start: &mut Start, steps: &mut Steps) -> Status {
        let search = &mut self.double;
        let n = block.rows.joints();
        if *start.infeasible {
            search.start[..n].copy_from_slice(start.regularized);
        } else if search.reach(block, start.lambda, steps) {
            return search.certify(block, &search.ascent.residual);
        } else {
            search.start[..n].copy_from_slice(start.lambda);
        }
        if search.approach(block, steps) {
            start.lambda.copy_from_slice(&search.lambda[..n]);
            start.regularized.copy_from_slice(&search.start[..n]);
            let status = search.certify(block, &search.ascent.residual);
            *start.infeasible = status == Status::Infeasible;
            return status;
        }
        if !core::mem::take(start.infeasible) {
            start.lambda.copy_from_slice(&search.lambda[..n]);
        } else if search.reach(block, start.lambda, steps) {
            return search.certify(block, &search.ascent.residual);
        }
        // The search may have ended at another torque.
        search.ascent.measure(block);
        Status::NotConverged
    }

    /// The search in numbers with more digits, from nothing.
    #[cold]
    fn solve_wide(&mut self, block: &Block<Sparse, f64>, lambda: &mut [f64], steps: &mut Steps) -> Status {
        let (search, answer) = (&mut self.wide, &mut self.double.ascent);
        search.start.fill(Wide::ZERO);
        let found = search.approach(block, steps);
        search.hold_fixed_muscles(block);
        let tensions = answer.muscles.iter_mut().zip(&search.ascent.muscles);
        tensions.for_each(|(to, from)| to.tension = from.tension.rounded());
        lambda.iter_mut().zip(&search.lambda).for_each(|(to, from)| *to = from.rounded());
        answer.measure(block);
        if found { search.certify(block, &answer.residual) } else { Status::NotConverged }
    }
}

/// The search in one precision.
#[derive(Debug, Clone)]
struct Search<S> {
    settings: Settings,
    tolerances: Tolerances,
    ascent: Ascent<S>,
    /// Multipliers to start [`Search::approach`] from, then those after its first step; and those that it
    /// ends at.
    start: Vec<S>,
    lambda: Vec<S>,
    center: Vec<S>,
    /// The problem to solve: the torque desired, or the closest, and limits that leave no choice where that
    /// determines the tension.
    torque: Vec<S>,
    muscles: Vec<Muscle>,
    /// `tau - R^T F` of the closest torque.
    closest: Vec<S>,
}

impl<S: Scalar> Search<S> {
    fn new(muscles: usize, joints: usize, settings: &Settings, tolerances: Tolerances) -> Self {
        let per_joint = || alloc::vec![S::ZERO; joints];
        Self {
            settings: *settings,
            tolerances,
            ascent: Ascent::new(muscles, joints, tolerances),
            start: per_joint(),
            lambda: per_joint(),
            center: per_joint(),
            torque: per_joint(),
            muscles: alloc::vec![Muscle::default(); muscles],
            closest: per_joint(),
        }
    }

    /// Tensions that give the torque at least cost, from `lambda` on; false where there are none or rounding
    /// hides them.
    fn reach<R: Rows>(&mut self, block: &Block<R, S>, lambda: &mut [S], steps: &mut Steps) -> bool {
        self.ascent.maximise(block, None, lambda, steps) && self.is_accurate(lambda)
    }

    /// Whether multipliers are small enough for the tensions that are sums of their terms: where joints are
    /// hard to tell apart, large ones cancel and leave rounding in the tensions.
    ///
    /// ```text
    /// H_jj sum_k H_kk lambda_k^2 <= c^2 (|tau_j| + sum_i |R_ij F_i|)^2,     H = R^T W^-1 R
    /// ```
    fn is_accurate(&self, lambda: &[S]) -> bool {
        let Ascent { diagonal, residual, .. } = &self.ascent;
        let bound = self.settings.cancellation / self.tolerances.rounding;
        let energy: f64 = diagonal.iter().zip(lambda).map(|(h, x)| h * x.rounded() * x.rounded()).sum();
        let mut joints = diagonal.iter().zip(&residual.scale[..lambda.len()]);
        joints.all(|(h, scale)| *scale == 0.0 || h * energy <= bound * bound * scale * scale)
    }

    /// Tensions that give the torque or the closest one, at least cost among those that do; false where
    /// rounding hides them.
    ///
    /// ```text
    /// max_lambda  D(lambda) - eps/2 |lambda - center|^2           center := lambda, and again
    /// ```
    ///
    /// The proximal-point method on the dual, which is the augmented Lagrangian method on the problem: its
    /// torque goes to the closest, `tau - r`, and its multipliers grow by `r / eps` each time. As soon as `r`
    /// proves to be the least residual, the torque is replaced by the one found, which is within reach,
    /// muscles that it leaves no choice are fixed, and the growth is taken off the multipliers.
    ///
    /// # Source
    /// `chiche2014` for augmented Lagrangians of infeasible problems.
    fn approach<R: Rows>(&mut self, desired: &Block<R, f64>, steps: &mut Steps) -> bool {
        let (m, n) = (desired.muscles.len(), desired.rows.joints());
        self.muscles[..m].copy_from_slice(desired.muscles);
        self.torque.iter_mut().zip(desired.torque).for_each(|(to, from)| *to = S::from(*from));
        self.lambda[..n].copy_from_slice(&self.start[..n]);
        self.center[..n].fill(S::ZERO);
        let diagonal = self.ascent.set_floor(desired);
        let [first, later] = self.tolerances.regularization;
        let (mut reduced, mut last) = (false, f64::INFINITY);
        for step in 0..self.tolerances.proximal_steps {
            let regularization = diagonal * if step == 0 || reduced { first } else { later };
            let tolerance = if reduced { self.tolerances.residual } else { self.tolerances.gradient };
            let proximal = Proximal { regularization, center: &self.center[..n], tolerance };
            let block = Block { rows: desired.rows, muscles: &self.muscles[..m], torque: &self.torque[..n] };
            if !self.ascent.maximise(&block, Some(proximal), &mut self.lambda[..n], steps) {
                return false;
            }
            if step == 0 {
                self.start[..n].copy_from_slice(&self.lambda[..n]);
            }
            let Residual { torque, scale } = &self.ascent.residual;
            let error = relative(&torque[..n], scale);
            let stagnates = error <= 50.0 * self.tolerances.residual && error > 0.5 * last;
            last = error;
            if (error <= self.tolerances.residual || stagnates) && self.is_accurate(&self.lambda[..n]) {
                if reduced {
                    self.torque.iter_mut().zip(desired.torque).for_each(|(to, from)| *to = S::from(*from));
                    let torque = &self.torque[..n];
                    self.ascent.measure(&Block { rows: desired.rows, muscles: desired.muscles, torque });
                }
                return true;
            }
            if !reduced && self.is_closest(desired) {
                reduced = true;
                self.reduce(desired);
            }
            self.center[..n].copy_from_slice(&self.lambda[..n]);
        }
        false
    }

    /// What the residual says of a muscle: `None` where its tension leaves the residual's length as it is or
    /// there is one only, the limit that it has to be at otherwise.
    fn pulled_to<R: Rows>(&self, block: &Block<R, f64>, muscle: usize) -> Option<Limit> {
        let Residual { torque, scale } = &self.ascent.residual;
        let n = block.rows.joints();
        let certain = self.tolerances.rounding * norm(scale[..n].iter().copied())
            + self.tolerances.reduced_gradient * norm(torque[..n].iter().map(|r| r.rounded()));
        let certain = certain * norm(block.rows.row(muscle).map(|(_, arm)| arm));
        let reduced_gradient = block.rows.dot(muscle, &torque[..n]).rounded();
        let Muscle { lower, upper, .. } = block.muscles[muscle];
        let limit = if reduced_gradient > 0.0 { Limit::Upper } else { Limit::Lower };
        (reduced_gradient.abs() > certain && lower < upper).then_some(limit)
    }

    /// `h(d) - d^T R^T F`: by how much other tensions within the limits give more torque along a direction.
    fn gap<R: Rows>(&self, block: &Block<R, f64>, direction: &[S]) -> S {
        let mut gap = S::ZERO;
        for (i, (state, muscle)) in self.ascent.muscles.iter().zip(block.muscles).enumerate() {
            let pull = block.rows.dot(i, direction);
            let best = if pull > S::ZERO { muscle.upper } else { muscle.lower };
            gap = gap + pull * (S::from(best) - state.tension);
        }
        gap
    }

    /// Whether the residual is the least: the optimality conditions of `min |tau - R^T F|` within the limits.
    ///
    /// ```text
    /// R_i r >= 0 where F_max holds, <= 0 where F_min holds, = 0 elsewhere
    /// ```
    fn is_closest<R: Rows>(&self, block: &Block<R, f64>) -> bool {
        let n = block.rows.joints();
        let Residual { torque, scale } = &self.ascent.residual;
        let square = dot(&torque[..n], &torque[..n]).rounded();
        let least = self.tolerances.min_residual * norm(scale[..n].iter().copied());
        let muscles = &self.ascent.muscles;
        let holds = |i| self.pulled_to(block, i).is_none_or(|limit| limit == muscles[i].limit);
        square > least * least
            && self.gap(block, &torque[..n]).rounded() <= 0.1 * self.settings.gap * square
            && (0..block.muscles.len()).all(holds)
    }

    /// Makes the problem that remains where the torque is the closest one.
    fn reduce<R: Rows>(&mut self, block: &Block<R, f64>) {
        for i in 0..block.muscles.len() {
            match self.pulled_to(block, i) {
                Some(Limit::Upper) => self.muscles[i].lower = block.muscles[i].upper,
                Some(_) => self.muscles[i].upper = block.muscles[i].lower,
                None => {}
            }
        }
        let n = block.rows.joints();
        self.closest[..n].copy_from_slice(&self.ascent.residual.torque[..n]);
        let left = &self.closest[..n];
        let growth = dot(left, &self.lambda[..n]) / dot(left, left);
        for ((torque, lambda), left) in self.torque.iter_mut().zip(&mut self.lambda).zip(left) {
            *torque = *torque - *left;
            *lambda = *lambda - *left * growth;
        }
    }

    /// Adds to the multipliers what holds fixed muscles at their limits, the least multiple of the residual:
    /// the other muscles do not feel it.
    fn hold_fixed_muscles<R: Rows>(&mut self, block: &Block<R, f64>) {
        let n = block.rows.joints();
        let mut most = S::ZERO;
        for (i, (fixed, free)) in self.muscles.iter().zip(block.muscles).enumerate() {
            if fixed.lower < fixed.upper || free.lower >= free.upper {
                continue;
            }
            let missing = S::from(fixed.lower) - S::from(free.reference);
            let missing = missing / S::from(free.compliance) - block.rows.dot(i, &self.lambda[..n]);
            let factor = missing / block.rows.dot(i, &self.closest[..n]);
            most = if factor > most { factor } else { most };
        }
        for (lambda, left) in self.lambda[..n].iter_mut().zip(&self.closest) {
            *lambda = *lambda + *left * most;
        }
    }

    /// The status of an answer: the search's result, rounded.
    ///
    /// ```text
    /// reached:     |tau_j - R_j^T F| <= tol (|tau_j| + sum_i |R_ij F_i|)
    /// infeasible:  tau^T d > h(d) = sum_i max(R_i d F_min,i, R_i d F_max,i)  for some direction d
    /// closest:     every F within the limits leaves |tau - R^T F| >= (tau^T d - h(d)) / |d|
    /// ```
    ///
    /// With the least residual as the direction `d`, the last bound equals its length. Tensions of the form
    /// `clip(F_ref + W^-1 R lambda)` cost least for the torque that they give (weak duality).
    ///
    /// # Source
    /// Farkas' lemma for bounded variables: `boyd2004`, section 5.8.
    fn certify<R: Rows>(&self, block: &Block<R, f64>, answer: &Residual<f64>) -> Status {
        let n = block.rows.joints();
        if relative(&answer.torque[..n], &answer.scale) <= self.settings.feasibility {
            return Status::Optimal;
        }
        let direction = &self.closest[..n];
        let length = norm(direction.iter().map(|d| d.rounded()));
        let bound = dot(direction, &self.ascent.residual.torque[..n]) - self.gap(block, direction);
        let size = norm(answer.scale[..n].iter().copied());
        let least = bound.rounded() / length - self.tolerances.rounding * size;
        let closest = norm(answer.torque[..n].iter().copied())
            <= (1.0 + self.settings.gap) * least + self.settings.double.rounding * size;
        if least > 0.0 && closest { Status::Infeasible } else { Status::NotConverged }
    }
}

fn norm(x: impl Iterator<Item = f64>) -> f64 {
    libm::sqrt(x.map(|x| x * x).sum())
}
