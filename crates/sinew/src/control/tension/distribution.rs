//! The public solver: groups of joints solved one after the other, each from its last solution.

use super::ascent::Ascent;
use super::block::{Block, Muscle};
use super::pattern::{Group, Pattern};
use super::problem::{Limit, Problem, is_nonzero};
use super::rows::{Dense, Sparse};
use super::settings::Settings;
use super::solution::{Solution, Status};
use super::solver::{Solver, Start};
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
    solver: Solver,
    // The problem, in the pattern's order.
    arms: Vec<f64>,
    muscles: Vec<Muscle>,
    torque: Vec<f64>,
    // The last solution, in the pattern's order.
    lambda: Vec<f64>,
    /// Multipliers of the regularized dual, and the groups out of reach, to which they belong.
    regularized: Vec<f64>,
    infeasible: Vec<bool>,
    // The last solution, in the order of the problem.
    tension: Vec<f64>,
    residual: Vec<f64>,
    multiplier: Vec<f64>,
    limit: Vec<Limit>,
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
        let per_joint = || alloc::vec![0.0; joints];
        Self {
            pattern: Pattern::new(muscles, joints),
            solver: Solver::new(muscles, joints, settings),
            arms: alloc::vec![0.0; muscles * joints],
            muscles: alloc::vec![Muscle::default(); muscles],
            torque: per_joint(),
            lambda: per_joint(),
            regularized: per_joint(),
            infeasible: alloc::vec![false; joints + 1],
            tension: alloc::vec![0.0; muscles],
            residual: per_joint(),
            multiplier: per_joint(),
            limit: alloc::vec![Limit::Free; muscles],
        }
    }

    /// Drops the last solution and the groups of its arms: the next one starts from nothing, and has the bits
    /// that a new distribution gives.
    pub fn forget(&mut self) {
        self.pattern.clear();
    }

    /// The tensions for a torque, or for the closest that can be reached.
    ///
    /// # Errors
    /// As [`Problem::check`]; the last solution is then kept as a start.
    pub fn solve(&mut self, problem: &Problem) -> Result<Solution<'_>, Error> {
        let arms = problem.count_arms(self.tension.len(), self.residual.len())?;
        // Arms that became zero keep their places; a new one makes another pattern.
        if self.pattern.groups().is_empty() || self.gather_arms(problem) != arms {
            self.pattern.find(problem.moment_arms);
            self.gather_arms(problem);
            self.lambda.fill(0.0);
            self.infeasible.fill(false);
            self.solver.forget();
        }
        self.gather(problem);
        let (mut status, mut iterations) = (Status::Optimal, 0);
        for index in 0..self.pattern.groups().len() {
            let (group_status, steps) = self.solve_group(index);
            status = status.max(group_status);
            iterations += steps;
        }
        let Self { tension, residual, multiplier, limit, .. } = self;
        Ok(Solution { status, tension, residual, limit, multiplier, iterations })
    }

    fn solve_group(&mut self, index: usize) -> (Status, u32) {
        let Self { pattern, solver, .. } = self;
        let Group { muscles, joints, dense, operations } = pattern.groups()[index].clone();
        let n = joints.len();
        let block = Block {
            rows: Sparse {
                joints: n,
                start: &pattern.start[muscles.start..=muscles.end],
                column: &pattern.column,
                value: &self.arms,
            },
            muscles: &self.muscles[muscles.clone()],
            torque: &self.torque[joints.clone()],
        };
        let start = &mut Start {
            lambda: &mut self.lambda[joints.clone()],
            regularized: &mut self.regularized[joints.clone()],
            infeasible: &mut self.infeasible[index],
        };
        let arms = &self.arms[pattern.start[muscles.start]..pattern.start[muscles.end]];
        // Few joints, as robot arms have them, are worth loops of known length.
        let result = match (dense, n) {
            (true, 1) => solver.solve(&block, Dense::<1> { joints: n, arms }, start, operations),
            (true, 2) => solver.solve(&block, Dense::<2> { joints: n, arms }, start, operations),
            (true, 3) => solver.solve(&block, Dense::<3> { joints: n, arms }, start, operations),
            (true, 4) => solver.solve(&block, Dense::<4> { joints: n, arms }, start, operations),
            (true, 5) => solver.solve(&block, Dense::<5> { joints: n, arms }, start, operations),
            (true, 6) => solver.solve(&block, Dense::<6> { joints: n, arms }, start, operations),
            (true, 7) => solver.solve(&block, Dense::<7> { joints: n, arms }, start, operations),
            (true, 8) => solver.solve(&block, Dense::<8> { joints: n, arms }, start, operations),
            (true, _) => solver.solve(&block, Dense::<0> { joints: n, arms }, start, operations),
            (false, _) => solver.solve(&block, block.rows, start, operations),
        };
        // Into the order of the problem.
        let Ascent { muscles: states, residual, .. } = solver.answer();
        for ((&i, state), muscle) in pattern.muscles[muscles].iter().zip(states).zip(block.muscles) {
            self.tension[i] = state.tension;
            self.limit[i] = Limit::new(state.tension, muscle.lower, muscle.upper);
        }
        for (k, &j) in pattern.joints[joints].iter().enumerate() {
            (self.residual[j], self.multiplier[j]) = (residual.torque[k], start.lambda[k]);
        }
        result
    }

    /// Puts the arms into the pattern's order; the number of those that are not zero.
    fn gather_arms(&mut self, problem: &Problem) -> u64 {
        let mut count = 0;
        for (arm, &place) in self.arms.iter_mut().zip(self.pattern.source()) {
            let given = problem.moment_arms[place];
            let counts = is_nonzero(given);
            *arm = if counts { given } else { 0.0 };
            count += u64::from(counts);
        }
        count
    }

    /// Everything but the arms.
    fn gather(&mut self, problem: &Problem) {
        for (muscle, &i) in self.muscles.iter_mut().zip(&self.pattern.muscles) {
            *muscle = Muscle {
                lower: problem.minimum[i],
                upper: problem.maximum[i],
                reference: problem.reference[i],
                compliance: 1.0 / problem.weight[i],
            };
        }
        for (torque, &joint) in self.torque.iter_mut().zip(&self.pattern.joints) {
            *torque = problem.torque[joint];
        }
    }
}
