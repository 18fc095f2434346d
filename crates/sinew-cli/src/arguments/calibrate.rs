//! Arguments of `sinew calibrate`.

use super::machine::RootArgument;
use super::values::{number, workshop};
use clap::{Args, Subcommand};
use sinew::machine::Workshop;
use std::path::PathBuf;

/// Find the geometry of a machine with a camera: frames of joints, zeros of encoders, flex of links.
///
/// Poses that tell most about the end point are chosen, and others that judge; a motion through them is
/// verified as any other, and flown by a simulated machine before a simulated camera. DIR/calibration.toml
/// gives `sinew track` and `sinew run` the geometry; DIR/report.txt says how much it helps in poses that the
/// estimate has not seen, and how well every parameter is determined; DIR/readings.csv and
/// DIR/observations.csv are what `sinew calibrate fit` reads. Where these poses are not better, the exit code
/// is 3.
///
/// What a calibration may change, and by how much, are the tolerances of the machine: of its file, or
/// --tolerances.
///
/// With --no-camera the readings of the same motion give equivalent routes of the muscles and masses, judged
/// by lengths and torques at places that the estimate has not seen.
///
/// Example: sinew calibrate lm_arm --tolerances rough --out out
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct CalibrateArguments {
    #[command(subcommand)]
    pub(crate) verb: Option<CalibrateVerb>,
    #[command(flatten)]
    pub(crate) fly: CalibrateFlyArguments,
}

#[derive(Debug, Subcommand)]
pub(crate) enum CalibrateVerb {
    Plan(CalibratePlanArguments),
    Fit(CalibrateFitArguments),
}

// The help of the verb stands with the verb: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct ScenarioArguments {
    /// A machine's or robot's file, or the name of a built-in machine
    #[arg(default_value = "lm_arm")]
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Tolerances of a workshop in place of those in the machine's file
    #[arg(long, value_name = "WORKSHOP", value_parser = workshop())]
    pub(crate) tolerances: Option<Workshop>,
    /// Marker on a body at a place in its frame, m; may be given again [default: one at the end point,
    /// known
    /// to 0.3 mm]
    #[arg(long, value_name = "NAME=BODY:X,Y,Z")]
    pub(crate) marker: Vec<String>,
    /// Marker on the base at a place that is known to 0.05 mm, m; may be given again [default: three of
    /// a plate
    /// 0.3 m wide]
    #[arg(long, value_name = "NAME=X,Y,Z")]
    pub(crate) base_tag: Vec<String>,
    /// Poses to estimate from, 4 to 200
    #[arg(long, value_name = "N", default_value_t = 20,
        value_parser = clap::value_parser!(u16).range(4..=200))]
    pub(crate) poses: u16,
    /// Poses that judge, 1 to 100
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub(crate) check: u16,
    /// Seed of the simulated machine and camera, and of the poses that judge
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

// As above.
#[derive(Debug, Args)]
pub(crate) struct CalibrateFlyArguments {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArguments,
    /// The camera
    #[arg(long, value_name = "SOURCE", default_value = "simulated", value_parser = ["simulated"])]
    pub(crate) camera: String,
    /// Find equivalent routes of the muscles and masses from encoders, winches and load cells alone
    #[arg(long, conflicts_with_all = ["camera", "camera_fault", "marker", "base_tag"])]
    pub(crate) no_camera: bool,
    /// A fault of the simulated camera, may be given again: noise_m, delay_s, jitter_s, scale,
    /// distortion_m,
    /// outliers, dropouts, swapped (fractions), mirrored=1, moved_m=M (halfway)
    #[arg(long, value_name = "KEY=NUMBER")]
    pub(crate) camera_fault: Vec<String>,
    /// Start also a motion that simulated machines of the design do not track, and without trying
    #[arg(long)]
    pub(crate) unverified: bool,
    /// Folder for the results; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

/// Choose the poses of a calibration, and say what each would gain; nothing moves.
///
/// Example: sinew calibrate plan lm_arm --tolerances rough --out poses.csv
#[derive(Debug, Args)]
pub(crate) struct CalibratePlanArguments {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArguments,
    /// Table of the poses, waypoints of a motion (joints:FILE.csv)
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// Estimate from a recording and what a camera saw meanwhile.
///
/// RECORDING is a recording of `sinew run` or `sinew track`, or a table with the columns time_s and the
/// names of the joints, readings in rad or m. Observations are tables with the columns time_s, marker, x_m,
/// y_m and z_m in the camera's frame, TRC files, tables that OptiTrack's Motive exports, or MCAP files with
/// /tf or PoseStamped of ROS 2; which, their content tells. Their clock may differ by up to two seconds from
/// that of the readings. Every fifth place at rest judges.
///
/// Example: sinew calibrate fit lm_arm run.mcap --observations seen.csv --tolerances rough --out out
#[derive(Debug, Args)]
pub(crate) struct CalibrateFitArguments {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArguments,
    /// Readings of the encoders
    #[arg(value_name = "RECORDING.mcap|READINGS.csv", default_value = "readings.csv")]
    pub(crate) recording: PathBuf,
    /// What a camera saw; may be given again
    #[arg(long, value_name = "FILE", required_unless_present = "no_camera")]
    pub(crate) observations: Vec<PathBuf>,
    /// Find equivalent routes of the muscles and masses from encoders, winches and load cells alone
    #[arg(long, conflicts_with_all = ["observations", "unit", "clock", "marker", "base_tag"])]
    pub(crate) no_camera: bool,
    /// Folder for the results; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Unit of the observations' coordinates, m: 0.001 for millimetres [default: that of the file, else 1]
    #[arg(long, value_name = "M", value_parser = number("a number > 0", |x| x > 0.0))]
    pub(crate) unit: Option<f64>,
    /// What the observations' clock shows where that of the readings is 0, s [default: 0; for stamps since
    /// 1970 the start of the recording]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = number("a number", |_| true))]
    pub(crate) clock: Option<f64>,
}
