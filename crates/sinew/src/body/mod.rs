//! Rigid-body mechanics of a robot.
//!
//! [`Parts`] is a description, [`Robot`] a validated, immutable one. [`Robot::forward_kinematics`] writes
//! [`Poses`]; the dynamics algorithms use a preallocated [`Scratch`] and write slices. One algorithm per
//! file.

mod check;
pub(crate) mod cholesky;
mod coupling;
mod displacement;
mod energy;
mod forward_dynamics;
mod geom;
mod gravity_compensation;
mod independent;
mod integrate;
mod inverse_dynamics;
mod kinematics;
pub(crate) mod link;
mod link_state;
mod lumped;
mod mass_matrix;
mod part_error;
mod parts;
mod robot;
mod scratch;
pub(crate) mod symmetric;
mod tree;
pub(crate) mod vector;

pub use coupling::Reduction;
#[cfg(feature = "description")]
pub(crate) use coupling::curve;
pub use displacement::{Displacement, JointCorrection};
pub(crate) use energy::JointSpring;
pub(crate) use forward_dynamics::accelerations;
pub use geom::{Geom, GeomKind, MeshGeom, TriangleSurface};
pub(crate) use gravity_compensation::{Held, hold};
pub(crate) use independent::IndependentKinematics;
pub(crate) use kinematics::PoseRows;
pub use kinematics::{MotionAxis, Pose, Poses};
pub(crate) use link_state::ForwardScratch;
pub use part_error::PartError;
pub use parts::{
    Actuator, ActuatorKind, Body, Coupling, Joint, JointKind, Key, Parts, PathElement, SheathGeometry, Site,
    Tendon, TendonPath, Wrap, WrapKind,
};
pub use robot::Robot;
pub use scratch::Scratch;
