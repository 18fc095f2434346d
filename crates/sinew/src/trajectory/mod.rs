//! Where a robot is to be, when, and whether it can be there.
//!
//! ```text
//! path p(th)  --redundancy-->  joints q(th)  --time law th(t)-->  q, q', q'' at a time  --check-->  first obstacle
//! ```
//!
//! Everything is found before the start; [`Trajectory::sample`] only evaluates polynomials.

mod check;
mod joint_path;
mod motion;
mod path;
mod redundancy;
mod sequence;
mod spline;
mod time_law;
mod waypoints;

pub use check::{Demand, Limits, Obstacle, Reason, Shortfall, first_obstacle};
pub use joint_path::{JointPath, Miss};
pub use motion::{MinimumJerk, Reference, Trajectory};
pub use path::{EndPointPath, Loop};
pub use redundancy::Redundancy;
pub use sequence::Sequence;
pub use spline::Spline;
pub use time_law::{Progress, TimeLaw};
pub use waypoints::{Leg, Waypoint, legs};
