//! The answer: tensions, what is left of the torque, and which limits hold.

use super::block::{Block, Limit};
use super::exact::Exact;
use super::newton::{Outcome, REACHED, Work};
use super::pattern::{Group, Pattern, places};
use super::problem::{Problem, is_arm};
use super::rows::{LANES, Sparse};
use super::search::Search;
use super::softened::Soft;
use crate::Error;
use crate::dispatch::{self, Arithmetic, InstructionSet};
use alloc::vec::Vec;

/// Whether the torque is reached, worst last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It is, at least cost: no joint's residual exceeds 1e-9 of `|tau_j| + sum_i |R_ij F_i|`, and no tensions cost less
    /// that give the same torque.
    Optimal,
    /// No tensions within the limits give it. These give the closest one, and of those that do they cost least.
    Infeasible,
}

/// What [`Distribution::solve`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution<'a> {
    /// Whether the torque is reached.
    pub status: Status,
    /// `F`, N, `[muscles]`: within the limits, to the bit.
    pub tension: &'a [f64],
    /// `tau - R^T F`, N m, `[joints]`: rounding where the status is optimal.
    pub residual: &'a [f64],
    /// Which limit holds each muscle, `[muscles]`.
    pub limit: &'a [Limit],
    /// `lambda`, `[joints]`: `F = clip(F_ref + W^-1 R lambda, F_min, F_max)`, the proof of least cost. Twice it is what
    /// another N m at the joint would cost. Where the status is infeasible, it holds for muscles that the residual
    /// leaves a choice: those with `R (tau - R^T F) = 0`.
    pub multiplier: &'a [f64],
    /// Steps taken, over all groups of joints.
    pub iterations: u32,
}

/// Distributes torques over muscles.
///
/// Knows how many muscles and joints there are, remembers the multipliers of the last solution as a start for the next
/// ([`Distribution::forget`] drops them), and allocates nothing after construction.
///
/// ```text
/// min  sum_i w_i (F_i - F_ref,i)^2     s.t.   R^T F = tau,   F_min <= F <= F_max
/// ```
///
/// A torque that no tensions within the limits give is replaced by the closest in the Euclidean norm: least
/// `|tau - R^T F|_2` over the joints, every N m counting the same, weights without a say; among the tensions that give it,
/// those of least cost are returned.
///
/// The cost is strictly convex, so there is one solution; it is a continuous, piecewise linear function of `tau`,
/// `F_ref` and the limits. When the active set changes, the tensions bend but do not jump: a smooth torque gives smooth
/// tensions, and no history is needed for it: their rate is bounded by a constant times that of the torque (Lipschitz), out
/// of reach as well. The start only decides how many steps are taken.
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
/// `yuan2023` eq. (22).
#[derive(Debug, Clone)]
pub struct Distribution {
    pattern: Pattern,
    terms: Terms,
    instructions: InstructionSet,
    lambda: Vec<f64>,
    /// Multipliers where the torque was out of reach, and which groups these are.
    soft: Vec<f64>,
    beyond: Vec<bool>,
    work: Work,
    exact: Exact,
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

impl Distribution {
    /// For so many muscles and joints.
    #[must_use]
    pub fn new(muscles: usize, joints: usize) -> Self {
        Self {
            pattern: Pattern::new(muscles, joints),
            terms: Terms {
                value: alloc::vec![0.0; muscles * places(joints)],
                lower: alloc::vec![0.0; muscles],
                upper: alloc::vec![0.0; muscles],
                reference: alloc::vec![0.0; muscles],
                compliance: alloc::vec![0.0; muscles],
                torque: alloc::vec![0.0; places(joints)],
            },
            instructions: InstructionSet::detect(),
            lambda: alloc::vec![0.0; places(joints)],
            soft: alloc::vec![0.0; places(joints)],
            beyond: alloc::vec![false; joints + 1],
            work: Work::new(muscles, joints),
            exact: Exact::new(muscles, joints),
            tension: alloc::vec![0.0; muscles],
            residual: alloc::vec![0.0; joints],
            multiplier: alloc::vec![0.0; joints],
            limit: alloc::vec![Limit::Free; muscles],
        }
    }

    /// The next solution starts from nothing.
    pub fn forget(&mut self) {
        self.lambda.fill(0.0);
        self.beyond.fill(false);
    }

    /// The tensions for a torque, or for the closest that can be reached.
    ///
    /// # Errors
    /// As [`Problem::check`]; the last solution is then kept as a start.
    pub fn solve(&mut self, problem: &Problem) -> Result<Solution<'_>, Error> {
        let mut told = Ok(());
        self.instructions.run(TakeOver { distribution: self, problem, told: &mut told });
        told?;
        let (mut status, mut iterations) = (Status::Optimal, 0);
        for at in 0..self.pattern.groups.len() {
            status = status.max(self.solve_group(at, &mut iterations));
        }
        let Self { tension, residual, multiplier, limit, .. } = self;
        Ok(Solution { status, tension, residual, limit, multiplier, iterations })
    }

    /// Checks the problem and puts it into the pattern's order.
    #[inline(always)]
    fn take_over(&mut self, problem: &Problem) -> Result<(), Error> {
        let (muscles, joints) = (self.tension.len(), self.residual.len());
        let arms = problem.count_arms(muscles, joints)?;
        self.terms.gather_arms(&self.pattern, problem);
        if !self.pattern.found || !self.terms.has(arms, &self.pattern) {
            self.pattern.find(muscles, problem.moment_arms);
            self.terms.gather_arms(&self.pattern, problem);
            self.forget();
        }
        self.terms.gather(&self.pattern, problem);
        Ok(())
    }

    fn solve_group(&mut self, at: usize, iterations: &mut u32) -> Status {
        let group = self.pattern.groups[at].clone();
        let (m, n) = (group.muscles.len(), group.joints.len());
        // Each step settles at least one muscle; a few remove rounding.
        let most = 10 + u32::try_from((m + n) / 2).unwrap_or(u32::MAX / 2);
        if self.search(at, &group, most, iterations) != Outcome::Reached {
            let block = self.terms.block(&self.pattern, &group);
            let lambda = &mut self.lambda[group.joints.clone()];
            self.exact.solve(&block, lambda, &mut self.work.tension[..m], iterations);
            self.work.measure(&block);
        }
        self.scatter(&group);
        if self.work.error(n) <= REACHED { Status::Optimal } else { Status::Infeasible }
    }

    /// Multipliers and tensions of a group, but where they need more digits.
    #[inline(always)]
    fn search(&mut self, at: usize, group: &Group, most: u32, steps: &mut u32) -> Outcome {
        let Self { pattern, terms, work, lambda, soft, beyond, instructions, .. } = self;
        let search = Search {
            work,
            block: terms.block(pattern, group),
            arms: &terms.value[pattern.start[group.muscles.start]..pattern.start[group.muscles.end]],
            whole: group.whole,
            lambda: &mut lambda[group.joints.clone()],
            soft: Soft { lambda: &mut soft[group.joints.clone()], known: &mut beyond[at] },
            most,
            steps,
        };
        search.run(*instructions)
    }

    /// Puts a group's answer into the order of the problem.
    #[inline(always)]
    fn scatter(&mut self, group: &Group) {
        let limits =
            self.terms.lower[group.muscles.clone()].iter().zip(&self.terms.upper[group.muscles.clone()]);
        let muscles = self.pattern.muscles[group.muscles.clone()].iter().zip(&self.work.tension);
        for ((&muscle, &tension), (&lower, &upper)) in muscles.zip(limits) {
            self.tension[muscle] = tension;
            self.limit[muscle] = Limit::of(tension, lower, upper);
        }
        for (k, &joint) in self.pattern.joints[group.joints.clone()].iter().enumerate() {
            if let Some(residual) = self.residual.get_mut(joint) {
                *residual = self.work.residual[k];
                self.multiplier[joint] = self.lambda[group.joints.start + k];
            }
        }
    }
}

/// [`Distribution::take_over`] on the best instruction set.
struct TakeOver<'a, 'b> {
    distribution: &'a mut Distribution,
    problem: &'a Problem<'b>,
    told: &'a mut Result<(), Error>,
}

impl dispatch::Work for TakeOver<'_, '_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        *self.told = self.distribution.take_over(self.problem);
    }
}

impl Terms {
    /// Takes the moment arms over, in the pattern's order.
    #[inline(always)]
    fn gather_arms(&mut self, pattern: &Pattern, problem: &Problem) {
        let (arms, joints) = (problem.moment_arms, problem.torque.len());
        for group in &pattern.groups {
            let entries = pattern.start[group.muscles.start]..pattern.start[group.muscles.end];
            let values = &mut self.value[entries.clone()];
            if let Some((first, count)) = group.beside {
                let muscles = &pattern.muscles[group.muscles.clone()];
                let starts = muscles.iter().map(|muscle| muscle * joints + first);
                fill(values, group.joints.len(), count, &starts, arms);
            } else {
                for (value, &place) in values.iter_mut().zip(&pattern.source[entries]) {
                    *value = arms.get(place).copied().unwrap_or(0.0);
                }
            }
        }
    }

    /// Whether all of so many arms were taken over.
    #[inline(always)]
    fn has(&self, arms: usize, pattern: &Pattern) -> bool {
        let count = |sum: u64, value: &f64| sum + u64::from(is_arm(*value));
        pattern.complete || self.value[..pattern.source.len()].iter().fold(0, count) as usize == arms
    }

    /// Takes the rest of the problem over.
    #[inline(always)]
    fn gather(&mut self, pattern: &Pattern, problem: &Problem) {
        let count = pattern.muscles.len();
        let Self { lower, upper, reference, compliance, .. } = self;
        let (lower, upper) = (&mut lower[..count], &mut upper[..count]);
        let (reference, compliance) = (&mut reference[..count], &mut compliance[..count]);
        let (minimum, maximum) = (&problem.minimum[..count], &problem.maximum[..count]);
        let (wanted, weight) = (&problem.reference[..count], &problem.weight[..count]);
        for (k, &muscle) in pattern.muscles.iter().enumerate() {
            lower[k] = minimum[muscle];
            upper[k] = maximum[muscle];
            reference[k] = wanted[muscle];
            compliance[k] = 1.0 / weight[muscle];
        }
        self.gather_torque(pattern, problem);
    }

    #[inline(always)]
    fn gather_torque(&mut self, pattern: &Pattern, problem: &Problem) {
        for (torque, &joint) in self.torque.iter_mut().zip(&pattern.joints) {
            *torque = problem.torque.get(joint).copied().unwrap_or(0.0);
        }
    }

    #[inline(always)]
    fn block<'a>(&'a self, pattern: &'a Pattern, group: &Group) -> Block<'a, Sparse<'a>> {
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

/// Rows of `count` arms, filled up to `width` with zeros, from where each starts in `arms`.
#[inline(always)]
fn fill(
    rows: &mut [f64],
    width: usize,
    count: usize,
    starts: &(impl Iterator<Item = usize> + Clone),
    arms: &[f64],
) {
    for at in (0..width).step_by(LANES) {
        let mut keep = [0; LANES];
        keep.iter_mut().take(count - at).for_each(|keep| *keep = u64::MAX);
        for (row, start) in rows.chunks_exact_mut(width).zip(starts.clone()) {
            let from = arms.get(start + at..).unwrap_or_default();
            let to = &mut row[at..at + LANES];
            // What follows the row is read as well, but at the end of the matrix.
            if let Some(from) = from.first_chunk::<LANES>() {
                for k in 0..LANES {
                    to[k] = f64::from_bits(from[k].to_bits() & keep[k]);
                }
            } else {
                to[from.len()..].fill(0.0);
                to[..from.len()].copy_from_slice(from);
            }
        }
    }
}
