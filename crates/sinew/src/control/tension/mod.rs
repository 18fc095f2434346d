//! Tension distribution: which tension each of the redundant muscles gets, so that together they give a joint
//! torque.
//!
//! ```text
//! min_F  1/2 (F - F_ref)^T W (F - F_ref)     s.t.   R^T F = tau,   F_min <= F <= F_max
//! ```
//!
//! [`Distribution`] solves a [`Problem`] and always returns a [`Solution`]; where no tensions within the
//! limits give the torque, they give the closest one. The method is a semismooth Newton ascent on the dual,
//! which has one unknown per joint.
//!
//! | file | content |
//! |---|---|
//! | `problem`, `settings`, `solution` | problem, checks, tolerances, solution, status |
//! | `distribution` | the public solver: groups of joints, warm starts |
//! | `pattern` | joints that share no muscle are separate problems |
//! | `solver` | the method: ascent, closest torque, proof, in `f64`, then in `scalar::Wide` |
//! | `ascent`, `line_search`, `factor` | the dual ascent, regularized or not |
//! | `block` | one group's problem, its muscles and residual |
//! | `rows` | dense and sparse moment arms |
//! | `cocontraction` | reference tensions for a level of co-contraction |

mod ascent;
mod block;
mod cocontraction;
mod distribution;
mod factor;
mod line_search;
mod pattern;
mod problem;
mod rows;
mod scalar;
mod settings;
mod solution;
mod solver;

pub use cocontraction::cocontract;
pub use distribution::Distribution;
pub use problem::{Limit, Problem};
pub use settings::{Settings, Tolerances};
pub use solution::{Solution, Status};
