//! Drive sizing: from required tension, speed, acceleration and stroke of a cable to motor, ratio and winch.
//!
//! ```text
//! requirement, catalogue -> for every motor and reducer: feasible ratios -> the best design -> its envelope
//! ```

mod choice;
mod design;
mod envelope;
#[cfg(test)]
mod tests;

pub use choice::{Choice, choose};
pub use design::{Demand, Design, Limit, Requirement};
pub use envelope::{Bound, EnvelopePoint};
