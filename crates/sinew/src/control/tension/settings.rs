//! Tolerances and limits of the method.

/// Settings of [`Distribution`](super::Distribution); the defaults are meant for every problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Newton steps allowed per group of joints in one solution, in both precisions together; a search that
    /// needs more ends with [`Status::NotConverged`](super::Status::NotConverged). Default 20 000, which no
    /// problem known needs.
    pub max_iterations: u32,
    /// Multiplications allowed per group of joints in one solution, and a hundredth as many in the numbers
    /// with more digits: bounds the time of large problems, with the same end. Default 5e9, one to two
    /// seconds.
    pub max_operations: u64,
    /// A torque counts as reached where no joint's residual exceeds this part of `|tau_j| + sum_i |R_ij
    /// F_i|`. Default 1e-12.
    pub feasibility: f64,
    /// Largest part of the residual's length by which it may exceed the proved least one where a torque
    /// counts as the closest. Default 1e-7.
    pub gap: f64,
    /// Largest error of the tensions by cancellation in `R lambda`, relative to the largest tensions. Default
    /// 3e-11.
    pub cancellation: f64,
    /// Tolerances in `f64`, which is tried first.
    pub double: Tolerances,
    /// Tolerances in numbers of 512 bits.
    pub wide: Tolerances,
}

/// Tolerances that go with a precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Largest relative rounding error of a sum: smaller slopes and pivots count as zero.
    pub rounding: f64,
    /// The ascent stops at residuals below this part of `|tau_j| + sum_i |R_ij F_i|`, or below fifty times as
    /// much where rounding keeps them from falling further.
    pub residual: f64,
    /// Regularization of the dual, relative to the largest diagonal entry of the Newton matrix. First, and
    /// again once the closest torque is known: small enough to leave the active set as it is. Between: large
    /// enough for multipliers, which grow with its inverse, to leave the residual accurate.
    pub regularization: [f64; 2],
    /// The ascent of the regularized dual stops at gradients below this part of `|tau_j| + sum_i |R_ij F_i|`:
    /// the rounding of multipliers that grow with the inverse of the regularization.
    pub gradient: f64,
    /// Proximal steps: updates of the center of the regularization.
    pub proximal_steps: u32,
    /// Least residual, relative to the magnitudes of its terms, that is not taken for rounding.
    pub min_residual: f64,
    /// Least reduced gradient `R_i r`, relative to `|R_i| |r|`, whose sign is certain.
    pub reduced_gradient: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_iterations: 20_000,
            max_operations: 5_000_000_000,
            feasibility: 1e-12,
            gap: 1e-7,
            cancellation: 3e-11,
            double: Tolerances {
                rounding: 1e-14,
                residual: 2e-15,
                regularization: [1e-7, 1e-5],
                gradient: 1e-11,
                proximal_steps: 12,
                min_residual: 1e-7,
                reduced_gradient: 1e-11,
            },
            wide: Tolerances {
                rounding: 1e-150,
                residual: 1e-30,
                regularization: [1e-80, 1e-80],
                gradient: 1e-30,
                proximal_steps: 20,
                min_residual: 1e-60,
                reduced_gradient: 1e-60,
            },
        }
    }
}
