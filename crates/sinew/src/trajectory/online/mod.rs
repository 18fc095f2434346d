//! References made while the machine moves: from set-points of any kind to the joints, within limits.
//!
//! ```text
//! joints        ------------------------------->  limits of range, speed, acceleration  -->  preview  -->  reference
//! end point     --damped least squares-->  joints  --^
//! muscle lengths --least squares-->  joints  --^
//! ```
//!
//! A step takes a bounded number of operations and allocates nothing.

mod end_point;
mod follower;
mod limiter;
mod limits;
mod muscle_lengths;
mod preview;

pub use end_point::EndPointStep;
pub use follower::{Setpoint, SetpointFollower};
pub use limiter::{JointLimiter, Limited};
pub use limits::JointLimits;
pub use muscle_lengths::MuscleLengthStep;
pub use preview::Preview;
