//! Arguments of the verbs about machines.

use super::values::number;
use clap::{Args, Subcommand, ValueEnum};
use sinew::drive::Catalogue;
use std::path::PathBuf;

/// Machine files: a body with its cables, drives, sensors and task.
///
/// A MACHINE is a machine file (.toml), a robot file (.toml, .xml: MJCF, .urdf: URDF, .osim: OpenSim;
/// everything but the body has its default), or the name of a built-in machine: lm_arm, bench_joint,
/// planar_leg, finger, spring_finger, two_finger_hand, exosuit_elbow, surgical_wrist, shoulder, chain10.
#[derive(Debug, Args)]
pub(crate) struct MachineArguments {
    #[command(subcommand)]
    pub(crate) verb: MachineVerb,
}

// The help of the verb stands with the verb: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct BodyFiles {
    /// Muscles of a URDF robot (TOML) [default: NAME.muscles.toml beside NAME.urdf]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) root: RootArgument,
}

#[derive(Debug, Args)]
pub(crate) struct RootArgument {
    /// Folder outside of which no file is read that a body names, and in all of which packages of ROS are
    /// looked for [default: the nearest that holds the body and the file]
    #[arg(long = "root", value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MachineVerb {
    Show(MachineShowArguments),
    New(MachineNewArguments),
    Tune(MachineTuneArguments),
    Map(MachineMapArguments),
    Body(MachineBodyArguments),
    Evaluate(MachineEvaluateArguments),
    Convert(MachineConvertArguments),
}

/// Print every value of a machine with its unit and its origin: a line of the file, the body, or a default.
///
/// The first tables show what decides how the machine can be controlled. The dead band of a joint is the
/// angle (or length) by which it can move while its cables stick in their sheaths. Where a machine with held
/// winches leaves a pose by itself, the pose, the rate and the cause are named, and sites that the attachment
/// tolerance may move into the surface beside them.
///
/// Example: sinew machine show finger --picture finger.svg
#[derive(Debug, Args)]
pub(crate) struct MachineShowArguments {
    /// A machine's or robot's file, or the name of a built-in machine
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// Draw bodies, joints, cables and end point in the start pose
    #[arg(long, value_name = "FILE.svg", value_parser = super::values::svg)]
    pub(crate) picture: Option<PathBuf>,
}

/// Write a commented machine file for a body, with drives that are strong enough for a motion.
///
/// The motion: every joint moves sinusoidally over a fraction of its range, all at one period and at any
/// phases. The torques it needs are distributed over the muscles; every muscle gets the lightest drive of the
/// catalogue that holds its largest tension and reaches its speed with a quarter to spare. A body that works
/// with up to 60 N gets a cord, load cells and drums of its size; any other gets the default cable of 3 mm.
///
/// Ends with code 3 where no drive of the catalogue is strong enough for a muscle; the file is written.
///
/// Example: sinew machine new leg.xml --out leg.toml
#[derive(Debug, Args)]
pub(crate) struct MachineNewArguments {
    /// A robot's file (.toml, .xml, .urdf or .osim), or the name of a built-in machine, of which the body
    /// is copied
    pub(crate) body: PathBuf,
    /// Machine file to write; the path of the body is written relative to its folder
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) out: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// Period of the motion that drives are selected for
    #[arg(long, value_name = "SECONDS", default_value_t = 4.0,
        value_parser = number("0.01 to 3600 s", |s| (0.01..=3600.0).contains(&s)))]
    pub(crate) period: f64,
    /// Fraction of every joint's range that the motion covers
    #[arg(long, alias = "share", value_name = "FRACTION", default_value_t = 0.6,
        value_parser = number("a number in (0, 1]", |fraction| fraction > 0.0 && fraction <= 1.0))]
    pub(crate) fraction: f64,
    /// Radius of pulleys, m or as 8mm: tendons of constant moment arms for a body that is described by its
    /// joints alone
    #[arg(long, value_name = "RADIUS", value_parser = radius, conflicts_with = "muscles")]
    pub(crate) pulleys: Option<f64>,
    /// Tendons of a chain of n joints on pulleys: one more than joints, or two for every joint
    #[arg(long, value_name = "ROUTING", default_value = "n+1", requires = "pulleys")]
    pub(crate) routing: Routing,
    /// Force at the end point that the muscles exert beside the weight of the body [default: half of the
    /// moving weight]
    #[arg(long, value_name = "N", value_parser = number("0 to 100000 N", |n| (0.0..=1e5).contains(&n)))]
    pub(crate) tip_force: Option<f64>,
    /// Drives to choose from: dynamixel, feetech or moteus [default: motors with reducers of any make]
    #[arg(long, value_name = "NAME", value_parser = drives)]
    pub(crate) drives: Option<String>,
}

/// How tendons run over pulleys.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Routing {
    /// One tendon more than joints
    #[value(name = "n+1")]
    OneMore,
    /// Two tendons for every joint
    #[value(name = "2n")]
    Two,
}

/// The name of drives of the built-in catalogue.
fn drives(text: &str) -> Result<String, String> {
    let catalogue = Catalogue::built_in().map_err(|error| error.to_string())?;
    let names = catalogue.drives();
    let known = names.contains(&text).then(|| text.to_owned());
    known.ok_or_else(|| format!("expected drives of the catalogue: {}", names.join(", ")))
}

/// A length in m, or in mm where it says so.
fn radius(text: &str) -> Result<f64, String> {
    let (digits, unit) = text.strip_suffix("mm").map_or((text, 1.0), |digits| (digits, 1e-3));
    let length = digits.trim().parse::<f64>().map(|length| length * unit);
    length
        .ok()
        .filter(|r| (1e-4..=1.0).contains(r))
        .ok_or_else(|| "expected a radius from 0.1mm to 1 m, such as 8mm".to_owned())
}

/// Map what a machine can do over its workspace: torques and forces, payload, speed, stiffness, and which
/// muscle limits them.
///
/// Friction of the sheaths counts with the direction in which each cable slides: a muscle that winds in gives
/// less at its anchor than its drive pulls, one that pays out holds more. Payload is therefore given for
/// lifting, for holding whichever way the cables slid before, and for lowering; and for holding 10 s, a
/// minute, an hour and continuously from room temperature on, with the limit that binds and the changes of
/// the design that would raise it.
///
/// Example: sinew machine map lm_arm --report map.html
#[derive(Debug, Args)]
pub(crate) struct MachineMapArguments {
    /// A machine's or robot's file, or the name of a built-in machine
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// Number of poses, spread evenly over the joints' ranges, 10 to 20000
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u32).range(10..=20_000))]
    pub(crate) poses: u32,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

/// Derive the gains, limits and thresholds of a machine's controller from its own numbers, by rules.
///
/// For every joint it says what limits it, and whether a faster winch, a stiffer cable, a straighter sheath
/// or a finer encoder would help, found by evaluating the rules again with that one number changed. The table
/// of muscles gives the margins of the loop in which the winches damp the joints, the least over poses and
/// over machines sampled within the tolerances. `track` derives the same gains anew from the cables that it
/// has identified; a file written here can be changed by hand and given to it with --gains.
///
/// Example: sinew machine tune finger --out gains.json --report gains.html
#[derive(Debug, Args)]
pub(crate) struct MachineTuneArguments {
    /// A machine's or robot's file, or the name of a built-in machine
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// Number of machines sampled within the tolerances for the margins, 0 to 1000
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub(crate) specimens: u32,
    /// Write the gains (JSON), for `sinew track --gains`
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: Option<PathBuf>,
    /// Write an HTML report: picture, margins, limits of the joints, rules and their numbers
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

/// Print the joints, muscles and masses of a body and the warnings of its description, of robots that are no
/// machine, too.
#[derive(Debug, Args)]
pub(crate) struct MachineBodyArguments {
    /// A robot's file, or the name of a built-in one
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// Write an HTML report with moment arms and a three-dimensional view of the robot
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

/// Compute muscle lengths, moment arms (-dl/dq), wrap angles and gravity torques of a robot in given poses.
///
/// POSES.csv has one column per joint, by name, in rad or m; ball and free joints have JOINT.qw .qx .qy .qz
/// (and .x .y .z). Joints without a column stay at their reference position or follow their coupling.
#[derive(Debug, Args)]
pub(crate) struct MachineEvaluateArguments {
    /// A robot's file, or the name of a built-in one
    pub(crate) model: PathBuf,
    /// Table of poses
    #[arg(long, value_name = "POSES.csv")]
    pub(crate) poses: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: Option<PathBuf>,
}

/// Convert a robot between formats, given by the extensions: from .toml, .xml, .urdf or .osim to .toml or
/// .xml.
#[derive(Debug, Args)]
pub(crate) struct MachineConvertArguments {
    /// A robot's file, or the name of a built-in one
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// File to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) files: BodyFiles,
}
