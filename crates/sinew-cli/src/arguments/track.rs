//! Arguments of `sinew track`.

use super::session::SessionArguments;
use clap::Args;

/// Track a path with a simulated cable-driven arm.
///
/// The simulated arm deviates from the controller's model in masses, cable attachments, friction and sensor
/// offsets. Each cable is calibrated in a run of its own, then the end point tracks the path. An infeasible
/// path is refused before the simulation, with its first infeasible instant; so is one that two simulated
/// machines of the design do not track, even with lower gains.
///
/// to:X,Y,Z is a point-to-point motion from the start pose to a position (m), every joint with minimum jerk;
/// to-joints:JOINT=VALUE,.. to a pose (rad or m), in which joints that are not named stay. FILE.csv has
/// waypoints in the columns time_s, x_m, y_m, z_m: two give a straight line with minimum jerk, more a smooth
/// curve from rest to rest through all of them at their times; a waypoint given twice in a row is a stop.
/// joints:FILE.csv is the same for the joints, with the columns time_s and names of joints (rad or m); joints
/// without a column stay at the start pose. tour is a closed motion of all joints over half of their ranges,
/// at a feasible speed.
///
/// Example: sinew track --duration 11.5 --repeats 1 --report track.html
///
/// Example: sinew track --path to:0.6,0.2,-0.2 --duration 3
#[derive(Debug, Args)]
pub(crate) struct TrackArguments {
    #[command(flatten)]
    pub(crate) session: SessionArguments,
}
