//! The geometry of a machine from what a camera sees of it: frames of joints, zeros of encoders, flex of
//! links.
//!
//! ```text
//! reading of joint i     r_i = q_i + z_i
//! link                   T_i = Trans(p_i + d_i) Rot(t_i) Rot(kappa_i m_i) Rot(axis_i, r_i - z_i)
//! marker k               y = (1 + sigma) (R_c x_k(q) + t_c) + e,    x_k: at o_k on its body
//! min  sum rho(|y - y(theta)| / s) + sum (theta / tolerance)^2
//! ```
//!
//! Without a camera, readings at rest ([`rests`](fn@rests)) give equivalent routes ([`RouteModel`]) and loads
//! ([`LoadModel`]).
//!
//! [`places`] makes places at rest from readings and sightings, [`estimate`](fn@estimate) finds the most
//! probable
//! parameters, [`plan`](fn@plan) chooses poses, [`GeometryModel`] is the model.

#[cfg(test)]
mod cable_tests;
mod estimate;
mod loads;
mod model;
mod place;
mod places;
mod plan;
mod prior_fit;
mod rests;
mod routes;
mod start;
#[cfg(test)]
mod tests;

pub use estimate::{Estimate, Finding, PointError, estimate};
pub use loads::{LoadEstimate, LoadModel, LoadPart};
pub use model::{GeometryModel, Parameter, ParameterKind, Sensitivity};
pub use place::{Place, Seen};
pub use places::{Frame, Readings, places, speed_delay, travel_ratio};
pub use plan::{Plan, plan};
pub use rests::{CableReadings, Rest, rests};
pub use routes::{RouteEstimate, RouteModel, RoutePart};

/// Why a geometry could not be estimated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A number outside the domain of the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// Observations that cannot belong to this machine.
    #[error("{0}")]
    Observations(String),
}
