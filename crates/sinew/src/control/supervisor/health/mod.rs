//! Slow changes of the cables: friction, pretension and stiffness, from motor-side signals and joint
//! encoders.

mod drift;
mod explanation;
mod sliding;
mod torque;
mod watch;

pub use drift::Drift;
pub use watch::CableHealth;
pub(super) use watch::HealthMonitor;
