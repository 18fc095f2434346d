//! Solution of a distribution problem and its status.

use super::problem::Limit;

/// Whether the torque is reached, worst last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It is, at least cost: no joint's residual exceeds
    /// [`Settings::feasibility`](super::Settings::feasibility), and no tensions within the limits that give
    /// the same torque cost less.
    Optimal,
    /// No tensions within the limits give it, which is proved. These give the closest torque and, of those
    /// that do, cost least.
    Infeasible,
    /// The search ended at [`Settings::max_iterations`](super::Settings::max_iterations) or by rounding, or
    /// its result could not be certified. Tensions are within their limits and belong to the last
    /// multipliers, but nothing is proved.
    NotConverged,
}

/// What [`Distribution::solve`](super::Distribution::solve) returns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution<'a> {
    /// Whether the torque is reached.
    pub status: Status,
    /// `F`, N, `[muscles]`: within the limits, bit for bit.
    pub tension: &'a [f64],
    /// `tau - R^T F`, N m, `[joints]`: rounding where the status is optimal.
    pub residual: &'a [f64],
    /// The limit that determines each muscle's tension, `[muscles]`.
    pub limit: &'a [Limit],
    /// `lambda`, N/m, `[joints]`: `F = clip(F_ref + W^-1 R lambda, F_min, F_max)` certifies least cost. It is
    /// the derivative of the cost (N^2, weights being dimensionless) with respect to the torque. Where the
    /// status is infeasible, it holds for muscles that the closest torque leaves a choice: those with `R_i
    /// (tau - R^T F) = 0`.
    pub multiplier: &'a [f64],
    /// Newton steps taken, over all groups of joints.
    pub iterations: u32,
}
