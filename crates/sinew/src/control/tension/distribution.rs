//! The public solver: groups of joints solved one after the other, each from its last solution.

use super::pattern::{Group, Pattern};
use super::problem::{Limit, Problem, is_nonzero};
use super::rows::{Block, Dense, Sparse};
use super::settings::Settings;
use super::solution::{Solution, Status};
use super::solver::{GroupStart, Solver};
use crate::Error;
use alloc::vec::Vec;

/// Distributes torques over muscles.
///
/// ```text
/// min_F  1/2 (F - F_ref)^T W (F - F_ref)     s.t.   R^T F = tau,   F_min <= F <= F_max
/// ```
///
/// The cost is strictly convex: there is one solution, and with multipliers `lambda` it is the one point with
///
/// ```text
/// R^T F = tau,     F = clip(F_ref + W^-1 R lambda, F_min, F_max)
/// ```
///
/// # Out of reach
/// A torque that no tensions within the limits give is replaced by the closest in the Euclidean norm: least
/// `|tau - R^T F|` over the joints, every N m counting the same, whatever the weights. Among the tensions
/// that give it, those of least cost are returned.
///
/// # Continuity
/// The solution is a continuous, piecewise linear function of `tau`, `F_ref` and the limits: where the active
/// set changes, the tensions bend but do not jump, and their rate is bounded by a constant times that of the
/// torque (Lipschitz), out of reach as well. It does not depend on the start; the last solution is kept as a
/// start because it saves steps ([`Distribution::forget`] drops it).
///
/// # Method
/// Joints that share no muscle are separate problems. Each is solved by a semismooth Newton method on the
/// dual, which has one unknown per joint (`qi1993`, `hermans2019`); where the dual is unbounded, by the
/// proximal-point method on the dual (`chiche2014`) until its torque proves to be the closest. Where rounding
/// stops these or their proof, the latter is repeated in numbers of 512 bits, in which numbers that differ by
/// many powers of ten need no scaling: a small problem then takes milliseconds. Nothing allocates after
/// construction.
///
/// # Certificates
/// [`Status::Optimal`] by the two conditions above, [`Status::Infeasible`] by a separating direction (Farkas)
/// that also bounds the distance of every reachable torque; both are checked on the tensions returned, in the
/// units of the problem.
///
/// # Example
/// ```
/// use sinew::control::tension::{Distribution, Problem, Status};
///
/// // A flexor and an extensor at one joint, both at 3 cm.
/// let mut distribution = Distribution::new(2, 1);
/// let problem = Problem {
///     moment_arms: &[0.03, -0.03],
///     torque: &[1.5],
///     minimum: &[20.0, 20.0],
///     maximum: &[400.0, 400.0],
///     reference: &[0.0, 0.0],
///     weight: &[1.0, 1.0],
/// };
/// let solution = distribution.solve(&problem)?;
/// assert_eq!(solution.status, Status::Optimal);
/// assert!((solution.tension[0] - 70.0).abs() < 1e-9 && (solution.tension[1] - 20.0).abs() < 1e-9);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// The problem: `yuan2023` eq. (22).
#[derive(Debug, Clone)]
pub struct Distribution {
    pattern: Pattern,
    terms: Terms,
    start: Start,
    solver: Solver,
    // In the order of the problem.
    tension: Vec<f64>,
    residual: Vec<f64>,
    multiplier: Vec<f64>,
    limit: Vec<Limit>,
}

/// The problem in the pattern's order.
#[derive(Debug, Clone)]
struct Terms {
    value: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    reference: Vec<f64>,
    compliance: Vec<f64>,
    torque: Vec<f64>,
}

/// The last solution, in the pattern's order.
#[derive(Debug, Clone)]
struct Start {
    lambda: Vec<f64>,
    /// Multipliers of the regularized dual, and the groups out of reach, to which they belong.
    regularized: Vec<f64>,
    infeasible: Vec<bool>,
}

impl Distribution {
    /// For a number of muscles and joints.
    #[must_use]
    pub fn new(muscles: usize, joints: usize) -> Self {
        Self::with_settings(muscles, joints, &Settings::default())
    }

    /// The same with other tolerances and limits.
    #[must_use]
    pub fn with_settings(muscles: usize, joints: usize, settings: &Settings) -> Self {
        let per_muscle = alloc::vec![0.0; muscles];
        let per_joint = alloc::vec![0.0; joints];
        Self {
            pattern: Pattern::new(muscles, joints),
            terms: Terms {
                value: alloc::vec![0.0; muscles * joints],
                lower: per_muscle.clone(),
                upper: per_muscle.clone(),
                reference: per_muscle.clone(),
                compliance: per_muscle.clone(),
                torque: per_joint.clone(),
            },
            start: Start {
                lambda: per_joint.clone(),
                regularized: per_joint.clone(),
                infeasible: alloc::vec![false; joints + 1],
            },
            solver: Solver::new(muscles, joints, settings),
            tension: per_muscle,
            residual: per_joint.clone(),
            multiplier: per_joint,
            limit: alloc::vec![Limit::Free; muscles],
        }
    }

    /// Drops the last solution: the next one starts from nothing.
    pub fn forget(&mut self) {
        self.start.lambda.fill(0.0);
        self.start.infeasible.fill(false);
    }

    /// The tensions for a torque, or for the closest that can be reached.
    ///
    /// # Errors
    /// As [`Problem::check`]; the last solution is then kept as a start.
    pub fn solve(&mut self, problem: &Problem) -> Result<Solution<'_>, Error> {
        let arms = problem.count_arms(self.tension.len(), self.residual.len())?;
        // Arms that became zero keep their places; a new one makes another pattern.
        if !self.pattern.found || self.terms.gather_arms(&self.pattern, problem) != arms {
            self.pattern.find(self.tension.len(), problem.moment_arms);
            self.terms.gather_arms(&self.pattern, problem);
            self.forget();
        }
        self.terms.gather(&self.pattern, problem);
        let (mut status, mut iterations) = (Status::Optimal, 0);
        for index in 0..self.pattern.groups.len() {
            let (group_status, steps) = self.solve_group(index);
            status = status.max(group_status);
            iterations += steps;
        }
        let Self { tension, residual, multiplier, limit, .. } = self;
        Ok(Solution { status, tension, residual, limit, multiplier, iterations })
    }

    fn solve_group(&mut self, index: usize) -> (Status, u32) {
        let Self { pattern, terms, start, solver, .. } = self;
        let group = pattern.groups[index].clone();
        let arms = &terms.value[pattern.start[group.muscles.start]..pattern.start[group.muscles.end]];
        let (block, joints) = (terms.block(pattern, &group), group.joints.len());
        let mut start = GroupStart {
            lambda: &mut start.lambda[group.joints.clone()],
            regularized: &mut start.regularized[group.joints.clone()],
            infeasible: &mut start.infeasible[index],
        };
        // Three joints and fewer, as robot arms have them, are worth loops of known length.
        let (work, start) = (group.operations, &mut start);
        let result = match (group.dense, joints) {
            (true, 1) => solver.solve(&block, Dense::<1> { joints, arms }, start, work),
            (true, 2) => solver.solve(&block, Dense::<2> { joints, arms }, start, work),
            (true, 3) => solver.solve(&block, Dense::<3> { joints, arms }, start, work),
            (true, _) => solver.solve(&block, Dense::<0> { joints, arms }, start, work),
            (false, _) => solver.solve(&block, block.rows, start, work),
        };
        self.scatter(&group);
        result
    }

    /// Puts a group's solution into the order of the problem.
    fn scatter(&mut self, group: &Group) {
        let (tension, residual) = self.solver.result();
        let muscles = self.pattern.muscles[group.muscles.clone()].iter().zip(tension);
        let limits =
            self.terms.lower[group.muscles.clone()].iter().zip(&self.terms.upper[group.muscles.clone()]);
        for ((&muscle, &tension), (&lower, &upper)) in muscles.zip(limits) {
            self.tension[muscle] = tension;
            self.limit[muscle] = Limit::of(tension, lower, upper);
        }
        let joints = self.pattern.joints[group.joints.clone()].iter().zip(residual);
        for ((&joint, &residual), &lambda) in joints.zip(&self.start.lambda[group.joints.clone()]) {
            self.residual[joint] = residual;
            self.multiplier[joint] = lambda;
        }
    }
}

impl Terms {
    /// Puts the arms into the pattern's order; the number of those that are not zero.
    fn gather_arms(&mut self, pattern: &Pattern, problem: &Problem) -> u64 {
        let mut count = 0;
        for (value, &place) in self.value.iter_mut().zip(&pattern.source) {
            *value = problem.moment_arms[place];
            count += u64::from(is_nonzero(*value));
        }
        count
    }

    /// Everything but the arms.
    fn gather(&mut self, pattern: &Pattern, problem: &Problem) {
        let count = pattern.muscles.len();
        let Self { lower, upper, reference, compliance, .. } = self;
        let (lower, upper) = (&mut lower[..count], &mut upper[..count]);
        let (reference, compliance) = (&mut reference[..count], &mut compliance[..count]);
        let Problem { minimum, maximum, reference: desired, weight, .. } = problem;
        let (minimum, maximum) = (&minimum[..count], &maximum[..count]);
        let (desired, weight) = (&desired[..count], &weight[..count]);
        for (k, &muscle) in pattern.muscles.iter().enumerate() {
            lower[k] = minimum[muscle];
            upper[k] = maximum[muscle];
            reference[k] = desired[muscle];
            compliance[k] = 1.0 / weight[muscle];
        }
        for (torque, &joint) in self.torque.iter_mut().zip(&pattern.joints) {
            *torque = problem.torque[joint];
        }
    }

    fn block<'a>(&'a self, pattern: &'a Pattern, group: &Group) -> Block<'a, Sparse<'a>, f64> {
        let muscles = group.muscles.clone();
        Block {
            rows: Sparse {
                joints: group.joints.len(),
                start: &pattern.start[muscles.start..=muscles.end],
                column: &pattern.column,
                value: &self.value,
            },
            lower: &self.lower[muscles.clone()],
            upper: &self.upper[muscles.clone()],
            reference: &self.reference[muscles.clone()],
            compliance: &self.compliance[muscles],
            torque: &self.torque[group.joints.clone()],
        }
    }
}
