//! Muscles: path of each cable over the body, its length and its moment arms.
//!
//! [`Muscles`] is independent of the pose; [`Muscles::evaluate`] writes the [`Geometry`] of one pose;
//! [`MuscleDynamics`] adds the dynamics of the joints.

mod bend;
mod circle;
mod drawn;
mod dynamics;
mod geometry;
mod path;
mod pulleys;
mod sparse_arms;
mod spring;
mod surface;
#[cfg(test)]
pub(crate) mod tests;
mod topology;
mod worlds;

pub use dynamics::MuscleDynamics;
pub use geometry::{Geometry, Muscles};
pub use pulleys::{PulleyRouting, with_pulleys};
pub(crate) use worlds::MuscleWorlds;
