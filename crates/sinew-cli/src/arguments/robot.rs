//! Arguments of the verbs about robots.

use super::session::SessionArguments;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Cable-driven robots: inspect a model, evaluate its muscles, convert it.
///
/// A MODEL is a file (.toml: this program's format or a machine file, whose body is taken, .xml: MJCF, .urdf: URDF)
/// or the name of a built-in machine: lm_arm, bench_joint, planar_leg, finger, exosuit_elbow, surgical_wrist,
/// shoulder, chain10.
#[derive(Debug, Args)]
pub(crate) struct ArmArguments {
    #[command(subcommand)]
    pub(crate) verb: ArmVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ArmVerb {
    Inspect(InspectArguments),
    Evaluate(ArmEvaluateArguments),
    Convert(ConvertArguments),
}

/// Print a robot's joints, muscles, masses and the warnings of its description.
#[derive(Debug, Args)]
pub(crate) struct InspectArguments {
    /// A robot's file, or the name of a built-in one
    pub(crate) model: PathBuf,
    /// Muscles of a URDF robot (TOML) [default: NAME.muscles.toml beside NAME.urdf]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
    /// Write an HTML report with moment arms and a three-dimensional view of the robot
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

/// Compute muscle lengths, moment arms (-dl/dq), wrap angles and gravity torques of a robot in given poses.
///
/// POSES.csv has one column per joint, by name, in rad or m; ball and free joints have JOINT.qw .qx .qy .qz
/// (and .x .y .z). Joints without a column stay at their reference position or follow their coupling.
#[derive(Debug, Args)]
pub(crate) struct ArmEvaluateArguments {
    /// A robot's file, or the name of a built-in one
    pub(crate) model: PathBuf,
    /// Table of poses
    #[arg(long, value_name = "POSES.csv")]
    pub(crate) poses: PathBuf,
    /// Muscles of a URDF robot (TOML) [default: NAME.muscles.toml beside NAME.urdf]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: Option<PathBuf>,
}

/// Convert a robot between formats, given by the extensions: from .toml, .xml or .urdf to .toml or .xml.
#[derive(Debug, Args)]
pub(crate) struct ConvertArguments {
    /// A robot's file, or the name of a built-in one
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// File to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Muscles of a URDF robot (TOML) [default: NAME.muscles.toml beside NAME.urdf]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
}

/// Track a path with a simulated cable-driven arm.
///
/// The simulated arm deviates from the controller's model in masses, cable attachments, friction and sensor
/// offsets. Each cable is calibrated in a run of its own, then the end point tracks the path. An infeasible
/// path is refused before the simulation, with its first infeasible instant; so is one that two simulated machines
/// of the design do not track, even with lower gains.
///
/// to:X,Y,Z is a point-to-point motion from the start pose to a position (m), every joint with minimum jerk;
/// to-joints:JOINT=VALUE,.. to a pose (rad or m), in which joints that are not named stay. FILE.csv has
/// waypoints in the columns time_s, x_m, y_m, z_m: two give a straight line with minimum jerk, more a smooth
/// curve from rest to rest through all of them at their times; a waypoint given twice in a row is a stop.
/// joints:FILE.csv is the same for the joints, with the columns time_s and names of joints (rad or m); joints
/// without a column stay at the start pose. tour is a closed motion of all joints over half of their ranges, at
/// a feasible speed.
///
/// Example: sinew track --duration 11.5 --repeats 1 --report track.html
///
/// Example: sinew track --path to:0.6,0.2,-0.2 --duration 3
#[derive(Debug, Args)]
pub(crate) struct TrackArguments {
    #[command(flatten)]
    pub(crate) session: SessionArguments,
}
