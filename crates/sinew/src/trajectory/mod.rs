//! Reference trajectories: a path of the end point, the joints along it, their timing, and a feasibility
//! check.
//!
//! ```text
//! path p(th)  --redundancy-->  joints q(th)  --time law th(t)-->  q, q', q'' at a time  --check-->  first infeasibility
//! ```
//!
//! Trajectories are those of the independent joints; the others follow by their couplings.
//!
//! Inverse kinematics and checks run before the start; [`Trajectory::sample`] only evaluates polynomials.

mod approach;
mod check;
mod controllable;
mod equilibrium;
mod inverse_kinematics;
mod joint_path;
mod joint_waypoints;
mod minimum_jerk;
mod motion;
mod nearest;
pub mod online;
mod path;
mod ranges;
mod redundancy;
mod reference;
mod schedule;
mod spline;
mod time_law;
mod tour;
mod unreached;
mod violation;
mod waypoints;

pub use approach::Approach;
pub use check::{Limits, TorqueDeficit, TorqueDemand, first_infeasibility, first_unreachable};
pub use controllable::ControllableMotion;
pub use equilibrium::Equilibrium;
pub use joint_path::JointPath;
pub use joint_waypoints::{JointWaypoint, through_joint_waypoints};
pub use minimum_jerk::MinimumJerk;
pub use motion::{Sequence, Trajectory};
pub use path::{EndPointPath, Loop, Waypoint};
pub use ranges::{finite_ranges, independent_ranges};
pub use redundancy::Redundancy;
pub use reference::Reference;
pub use schedule::{Moment, Schedule};
pub use spline::Spline;
pub use time_law::{PhaseState, TimeLaw};
pub use tour::{Tour, feasible_tour};
pub use unreached::{UnreachedCause, UnreachedPoint};
pub use violation::{Infeasibility, Violation};
pub use waypoints::{PathSegment, split_at_rests};
