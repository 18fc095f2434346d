//! What the muscles of a machine can give in a pose: joint torques, forces of the end point, payload, speed and
//! stiffness, through the transmission.
//!
//! ```text
//! T(q) = { R^T F :  F_min,k <= F_k <= F_max,k }                 torques of the joints: a zonotope
//! E(q) = { f :  g + J^T f in T(q) }                             forces that the end point exerts: a polytope
//! F_max,k = F_drive exp(-A_k) + T_0,k   while the drive winds in,   F_drive exp(+A_k) + T_0,k   while it pays out
//! ```
//!
//! | symbol  | meaning                                          | unit  |
//! |---------|--------------------------------------------------|-------|
//! | R, J    | moment arms, Jacobian of the end point            | m     |
//! | g       | torque that gravity and springs of the joints need | Nm   |
//! | A, T_0  | friction angle and pretension of a cable           | 1, N  |
//! | F_drive | tension of the drive                               | N     |
//!
//! Small sets are given by vertices and facets, sets of any size by their support function and by the largest
//! multiple of a load that they contain.

mod directions;
mod holding;
mod limits;
mod linear;
mod load;
mod model;
mod pose;
mod stiffness;
#[cfg(test)]
mod tests;
mod torque_set;
mod zonotope;

pub use holding::{HeldPayload, TensionLimit};
pub use limits::{CableMotion, SlidingState, anchor_limits};
pub use load::{Binding, LargestLoad, LoadSearch};
pub use model::{CapabilityModel, EndPointJacobian};
pub use pose::{EndPointCapability, Extreme, JointCapability, PoseCapability};
pub use torque_set::{Facet, Polytope, TorqueSet};
