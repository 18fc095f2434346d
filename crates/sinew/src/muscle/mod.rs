//! Muscles: path of each cable over the body, its length and its moment arms.
//!
//! [`Muscles`] is independent of the pose; [`Muscles::evaluate`] writes the [`Geometry`] of one pose.

mod bend;
mod circle;
mod geometry;
mod path;
mod rate;
mod surface;
mod topology;

pub use geometry::{Geometry, Muscles};
pub use rate::MomentArmRates;
