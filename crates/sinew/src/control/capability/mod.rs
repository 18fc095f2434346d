//! What the muscles of a machine can give in a pose: joint torques, forces of the end point, payload, speed
//! and stiffness, through the transmission.
//!
//! ```text
//! T(q) = { R^T F :  F_min,k <= F_k <= F_max,k }                 torques of the joints: a zonotope
//! E(q) = { f :  g + J^T f in T(q) }                             forces that the end point exerts: a polytope
//! [F_min,k, F_max,k] = [F_drive,min, F_drive,max] exp(-s A_k) + T_0,k
//!        direction unknown: the intersection of both ranges; tension limits of the machine file narrow it
//! ```
//!
//! | symbol  | meaning                                          | unit  |
//! |---------|--------------------------------------------------|-------|
//! | R, J    | moment arms, Jacobian of the end point            | m, or 1 for sliding joints |
//! | g       | torque that gravity and springs of the joints need | Nm or N |
//! | F, f    | tensions at the anchors, force of the end point    | N     |
//! | A, T_0  | friction angle and pretension of a cable           | 1, N  |
//! | s       | +1 while the drive winds in, -1 while it pays out  | 1     |
//! | F_drive | tension at the drive                               | N     |
//!
//! Sets are given by their support function and by the largest multiple of a load that they contain, sets of
//! two joints also by their outline.

mod directions;
mod holding;
mod limits;
mod load;
mod model;
mod pose;
mod stiffness;
#[cfg(test)]
mod tests;
mod torque_set;

pub use holding::{HeldPayload, TensionLimit};
pub use limits::{CableMotion, SlidingState, anchor_limits};
pub use load::{Binding, LargestLoad, LoadSearch};
pub use model::{CapabilityModel, EndPointJacobian};
pub use pose::{EndPointCapability, Extreme, JointCapability, PoseCapability};
pub use torque_set::TorqueSet;
