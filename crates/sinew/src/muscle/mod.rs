//! Muscles: the way of each cable over the body, its length and its moment arms.
//!
//! [`Muscles`] is what stays the same, [`Geometry`] what [`Muscles::evaluate`] finds in a pose.

mod bend;
mod circle;
mod geometry;
mod path;
mod rate;
mod surface;
mod topology;

pub use geometry::{Geometry, Muscles};
pub use rate::MomentArmRates;
