//! Reference trajectories: a path of the end point, the joints along it, their timing, and a feasibility
//! check.
//!
//! ```text
//! path p(th)  --redundancy-->  joints q(th)  --time law th(t)-->  q, q', q'' at a time  --check-->  first infeasibility
//! ```
//!
//! Inverse kinematics and checks run before the start; [`Trajectory::sample`] only evaluates polynomials.

mod check;
mod joint_path;
mod minimum_jerk;
mod motion;
mod path;
mod redundancy;
mod reference;
mod spline;
mod time_law;
mod waypoints;

pub use check::{Infeasibility, Limits, TorqueDeficit, TorqueDemand, Violation, first_infeasibility};
pub use joint_path::{JointPath, UnreachedPoint};
pub use minimum_jerk::MinimumJerk;
pub use motion::{Sequence, Trajectory};
pub use path::{EndPointPath, Loop, Waypoint};
pub use redundancy::Redundancy;
pub use reference::Reference;
pub use spline::Spline;
pub use time_law::{PhaseState, TimeLaw};
pub use waypoints::{PathSegment, split_at_rests};
