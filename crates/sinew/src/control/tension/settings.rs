//! Tolerances and limits of the method.

/// Settings of [`Distribution`](super::Distribution); the defaults are meant for every problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Newton steps allowed per group of joints in one solution, in both precisions together; a search that
    /// needs more ends with [`Status::NotConverged`](super::Status::NotConverged). Default 20 000, which no
    /// problem known needs.
    pub max_iterations: u32,
    /// A torque counts as reached where no joint's residual exceeds this part of `|tau_j| + sum_i |R_ij
    /// F_i|`. Default 1e-9.
    pub feasibility: f64,
    /// The ascent stops at residuals below this part of the same sum: a few units in the last place. Default
    /// 2e-15.
    pub residual: f64,
    /// Residual relative to the same sum that is accepted where rounding keeps it from falling further.
    /// Default 1e-13.
    pub stagnation: f64,
    /// Gap between the residual and the proved least residual, relative to the residual, up to which a torque
    /// counts as the closest. Default 1e-8.
    pub gap: f64,
    /// Slope of the dual along a step, relative to the magnitudes of its terms, that counts as zero. Default
    /// 1e-13.
    pub zero_slope: f64,
    /// Slope beyond the last breakpoint, relative to the same, from which on the dual counts as unbounded.
    /// Default 1e-11.
    pub positive_slope: f64,
    /// Tolerances in `f64`, which is tried first.
    pub double: Tolerances,
    /// Tolerances in numbers of twice the digits.
    pub double_double: Tolerances,
}

/// Tolerances that go with a precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Unit of relative rounding errors: `eps`.
    pub rounding: f64,
    /// Smallest pivot of the Newton matrix, relative to its diagonal with every muscle free: below it, the
    /// free muscles do not move the joint.
    pub pivot: f64,
    /// Largest ratio of the terms `R_ij lambda_j / w_i` to tensions: beyond it, their cancellation leaves
    /// rounding errors in the tensions.
    pub cancellation: f64,
    /// Regularization of the dual for torques out of reach, relative to the largest diagonal entry of the
    /// Newton matrix: small enough to leave the active set as it is, large enough to keep multipliers, which
    /// grow with its inverse, accurate. The first one, the least one, and the ratio of each proximal step's
    /// to the last.
    pub regularization: [f64; 3],
    /// The ascent of the regularized dual stops at gradients below this part of `|tau_j| + sum_i |R_ij F_i|`:
    /// the rounding of multipliers that grow with the inverse of the regularization.
    pub gradient: f64,
    /// Proximal steps: updates of the center of the regularization.
    pub proximal_steps: u32,
    /// Part of a muscle's row of arms, relative to the row, that is independent of other rows; twice: counts
    /// as none, counts as some. Between them, the rank is uncertain.
    pub rank: [f64; 2],
    /// Least residual, relative to the sum of the magnitudes of its terms, that is not taken for rounding.
    pub least_residual: f64,
    /// Least reduced gradient `R_i r`, relative to `|R_i| |r|`, whose sign is certain.
    pub reduced_gradient: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_iterations: 20_000,
            feasibility: 1e-9,
            residual: 2e-15,
            stagnation: 1e-13,
            gap: 1e-8,
            zero_slope: 1e-13,
            positive_slope: 1e-11,
            double: Tolerances {
                rounding: 1e-14,
                pivot: 1e-13,
                cancellation: 3e3,
                regularization: [1e-7, 1e-10, 1e-3],
                gradient: 1e-9,
                proximal_steps: 2,
                rank: [1e-12, 1e-4],
                least_residual: 1e-7,
                reduced_gradient: 1e-9,
            },
            double_double: Tolerances {
                rounding: 1e-29,
                pivot: 1e-28,
                cancellation: 1e16,
                regularization: [1e-14, 1e-20, 1e-2],
                gradient: 1e-16,
                proximal_steps: 50,
                rank: [1e-24, 1e-12],
                least_residual: 1e-15,
                reduced_gradient: 1e-13,
            },
        }
    }
}
