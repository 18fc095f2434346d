//! The flags as written.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Finds out what happens at the far end of a cable in its sheath from the motor's side alone.
///
/// Start with `sinew demo --out DIR`, or with a bench log of your own that has both ends in it:
/// `sinew identify LOG --far COLUMN --effort COLUMN --out DIR`, then open DIR/report.html.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, about, long_about, propagate_version = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Identify(IdentifyArguments),
    Evaluate(EvaluateArguments),
    Predict(PredictArguments),
    Adapt(AdaptArguments),
    Demo(DemoArguments),
    Arm(ArmArguments),
    Track(TrackArguments),
    Reproduce(ReproduceArguments),
    Bench(BenchArguments),
    Twin(TwinArguments),
    Tension(TensionArguments),
    Drive(DriveArguments),
}

/// Fit a transmission: from bench logs to DIR/model.json and DIR/report.html.
///
/// A bench log is a table (CSV, TSV, MATLAB v5; Parquet and MATLAB v7.3 in builds with those features) with a
/// row per sample: signals of the near side (the motor's) and the signal of the far end to be predicted. Roles
/// that no flag names are found by column names with unit suffixes: tension_in_n, position_in_m, tension_out_n,
/// anchor_m, time_s, trial.
///
/// Every model is judged on data it has not seen, held out in a way that mimics the question: other values of
/// --group, else of conditions found in the log (a load, a frequency), else other logs, other trials, other
/// stretches of time. States are reset at every trial and after every gap.
///
/// Example: sinew identify day1.csv day2.csv --far tension_out_n --effort tension_in_n --out out/sheath
#[derive(Debug, Args)]
pub(crate) struct IdentifyArguments {
    /// Bench logs with both ends of the transmission
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArguments,
    /// Seconds at the start of every trial that are neither fitted nor scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub(crate) skip: f64,
    /// Models to try: auto, or names from the report's table, separated by commas
    #[arg(long, value_name = "NAME,..", default_value = "auto", value_delimiter = ',')]
    pub(crate) model: Vec<String>,
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}

/// Columns by role.
#[derive(Debug, Args)]
pub(crate) struct RoleArguments {
    /// The far-end signal to predict
    #[arg(long, value_name = "COL")]
    pub(crate) far: Option<String>,
    /// Tensions or torques at the near side
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) effort: Vec<String>,
    /// Positions or strokes at the near side
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) motion: Vec<String>,
    /// Displacement of the far end, where a joint sensor gives it
    #[arg(long, value_name = "COL")]
    pub(crate) anchor: Option<String>,
    /// Slow quantities: a joint angle, the bend of the sheath
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) given: Vec<String>,
    /// Time; the suffixes _s, _ms and _us tell its unit
    #[arg(long, value_name = "COL")]
    pub(crate) time: Option<String>,
    /// Trial label: states are reset where it changes
    #[arg(long, value_name = "COL")]
    pub(crate) trial: Option<String>,
    /// Condition whose values are held out in turn when models are judged
    #[arg(long, value_name = "COL")]
    pub(crate) group: Option<String>,
}

/// Where results go.
#[derive(Debug, Args)]
pub(crate) struct WriteArguments {
    /// Folder for model.json and report.html; made if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Also write the loop and the trace as one SVG picture
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) picture: Option<PathBuf>,
    /// Seed of every random draw: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Judge a model on logs: MSE, RMSE, Pearson correlation, % of range, coverage of the 95 % band.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// Logs with the far end in them
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Seconds at the start of every trial that are not scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub(crate) skip: f64,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Predict the far end of logs, sample by sample as a stream would.
///
/// The file has a row per sample: log, trial, time_s, prediction, standard_deviation, gate (how far the learned
/// correction is trusted, 0 to 1) and flags: state_unknown, out_of_range, input_held, reset.
#[derive(Debug, Args)]
pub(crate) struct PredictArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// Logs of the near side
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// File to write
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// Calibrate a model to another specimen with a short log that has the far end in it.
///
/// No near-side signal tells that a tool was changed: after a change, record a few trials with the far side
/// measured and adapt. The old model is the prior; what the short log cannot tell stays as it was.
#[derive(Debug, Args)]
pub(crate) struct AdaptArguments {
    /// The model.json of the old specimen
    pub(crate) model: PathBuf,
    /// Short logs of the new specimen
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Seconds at the start of every trial that are neither fitted nor scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub(crate) skip: f64,
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}

/// Identify a simulated transmission: no log needed.
///
/// Two simulated days are fitted, a third is kept back and predicted. The logs are left beside the model;
/// everything is labelled as simulated.
#[derive(Debug, Args)]
pub(crate) struct DemoArguments {
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}

/// Robots moved by cables: look at a model, evaluate its muscles, convert it.
///
/// A MODEL is a file (.toml: this program's format, .xml: MJCF, .urdf: URDF) or the name of an embedded one: lm_arm.
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

/// Print what a robot is made of: joints, muscles, masses, warnings.
#[derive(Debug, Args)]
pub(crate) struct InspectArguments {
    /// A robot's file, or the name of an embedded one
    pub(crate) model: PathBuf,
    /// Muscles of a URDF robot (TOML); NAME.muscles.toml beside NAME.urdf is found by itself
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
    /// Write an HTML report with moment arms and a view of the robot
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Lengths, moment arms (-dl/dq), wrap angles and gravity torques of a robot in given poses.
///
/// POSES.csv has a column per joint, by name, in rad or m; ball and free joints have JOINT.qw .qx .qy .qz (and
/// .x .y .z). Joints left out stay at their reference, or follow their coupling.
#[derive(Debug, Args)]
pub(crate) struct ArmEvaluateArguments {
    /// A robot's file, or the name of an embedded one
    pub(crate) model: PathBuf,
    /// Table of poses
    #[arg(long, value_name = "POSES.csv")]
    pub(crate) poses: PathBuf,
    /// Muscles of a URDF robot (TOML); NAME.muscles.toml beside NAME.urdf is found by itself
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
    /// File to write; without it the table goes to standard output
    #[arg(long, value_name = "FILE.csv", conflicts_with = "json")]
    pub(crate) out: Option<PathBuf>,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Convert a robot between formats, chosen by extension: from .toml, .xml or .urdf to .toml or .xml.
#[derive(Debug, Args)]
pub(crate) struct ConvertArguments {
    /// A robot's file, or the name of an embedded one
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// File to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Muscles of a URDF robot (TOML); NAME.muscles.toml beside NAME.urdf is found by itself
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) muscles: Option<PathBuf>,
}

/// Track a path with a simulated arm on cables.
///
/// The arm is built with errors that the controller does not know (masses, attachments, friction, sensors), each of its
/// cables is calibrated by a run of its own, then the end point follows the path. A path that the robot cannot follow is
/// refused before the start, with the first place where it cannot.
///
/// to:X,Y,Z goes to a place, m, from the pose `start`: every joint with minimum jerk. FILE.csv has waypoints, columns
/// time_s, x_m, y_m, z_m: two are a straight line with minimum jerk, more a smooth curve from rest to rest that passes
/// every one in time; where one is given twice in a row the arm waits.
///
/// Example: sinew track --duration 11.5 --repeats 1 --report track.html
/// Example: sinew track --path to:0.6,0.2,-0.2 --duration 3
#[derive(Debug, Args)]
pub(crate) struct TrackArguments {
    /// A robot's file, or the name of an embedded one; it has a key pose `start` and a site `endpoint`
    #[arg(default_value = "lm_arm")]
    pub(crate) model: PathBuf,
    /// Way of the end point: sine, saddle, a place (m) to go to, or a table of waypoints
    #[arg(long, value_name = "sine|saddle|to:X,Y,Z|FILE.csv", default_value = "sine")]
    pub(crate) path: String,
    /// Seconds for two turns of a closed path [default: 115], or for the way to a place [default: 5]; waypoints have
    /// times of their own
    #[arg(long, value_name = "SECONDS")]
    pub(crate) duration: Option<f64>,
    /// How often [default: 6]; a way that does not end where it begins is gone once
    #[arg(long, value_name = "N")]
    pub(crate) repeats: Option<u32>,
    /// Repeats do not learn from those before them
    #[arg(long)]
    pub(crate) no_learning: bool,
    /// Seconds for which the arm is held at the end
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0)]
    pub(crate) hold: f64,
    /// none, capstan, paper: drives are told tensions; no_observer, no_disturbance_observer, observer, observer_network,
    /// perfect: winches are told speeds
    #[arg(long, value_name = "NAME", default_value = "observer")]
    pub(crate) compensation: String,
    /// Mass carried at the end point, kg; the controller knows it
    #[arg(long, value_name = "KG", default_value_t = 0.0)]
    pub(crate) payload: f64,
    /// What fails, and when, in s since the run began (the motion begins at 3 s): cable:MUSCLE@TIME, and for a while
    /// drive:MUSCLE@TIME+SECONDS, winch:.., motor-encoder:MUSCLE:HOW@.., load-cell:MUSCLE:HOW@.., joint-encoder:JOINT:HOW@..,
    /// HOW being stuck, lost or nan; may be given again
    #[arg(long, value_name = "WHAT:NAME@TIME")]
    pub(crate) fault: Vec<String>,
    /// Seed of how the arm is built and of its sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Write the run as a table (CSV), a row per 10 ms
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) record: Option<PathBuf>,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Reproduce the paper's experiments on the twin: tables and figures in DIR/report.html, numbers in DIR/results.json.
///
/// Calibration, identification and compensation of the bench at six speeds, then the arm along its path with every way of
/// control; everything is simulated and says so. --quick takes seconds and is coarser: fewer strokes, no other specimens, a
/// path ten times as fast.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// Which part of the paper
    #[arg(long, value_enum, default_value_t = Part::All)]
    pub(crate) part: Part,
    /// A look in seconds
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for report.html and results.json; made if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Seed of every random draw: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print the numbers as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Parts of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Part {
    /// Everything
    All,
    /// Tables I to III, figures 7 to 10
    Bench,
    /// Figures 11 to 13
    Arm,
}

/// The bench of the paper as a twin: two drives back to back over one cable.
#[derive(Debug, Args)]
pub(crate) struct BenchArguments {
    #[command(subcommand)]
    pub(crate) verb: BenchVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum BenchVerb {
    Run(BenchRunArguments),
}

/// Run the bench and write a log of its sensors, a row per millisecond.
///
/// Without --compensation the muscle's motor strokes and the load swings the far tension between 40 and 200 N: a
/// log to identify from. With it the load strokes and the muscle is to give the wanted far tension, by a
/// compensation that was calibrated on this specimen before.
///
/// Example: sinew bench run --speeds 0.04,0.08 --out bench.csv, then sinew identify bench.csv --out out/cable
#[derive(Debug, Args)]
pub(crate) struct BenchRunArguments {
    /// Strokes to keep: toward the muscle's motor, away from it, or whole cycles
    #[arg(long, value_enum, default_value_t = Muscle::Both)]
    pub(crate) muscle: Muscle,
    /// Speeds of the cable, m/s, 0.005 to 0.15
    #[arg(long, value_name = "V,..", value_delimiter = ',', default_value = "0.02,0.04,0.06,0.08,0.1,0.12")]
    pub(crate) speeds: Vec<f64>,
    /// Seconds at each speed, 1 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub(crate) duration: f64,
    /// How the far tension is aimed at; without it the run is a calibration
    #[arg(long, value_enum)]
    pub(crate) compensation: Option<CompensationKind>,
    /// Cable: bench (as calibrated to the paper's tables), ideal (without the effects no model knows), or a number to
    /// draw another one by
    #[arg(long, value_name = "NAME|N", default_value = "bench")]
    pub(crate) specimen: String,
    /// Seed of the sensors' noise and of what is learned
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Log to write (CSV)
    #[arg(long, value_name = "LOG")]
    pub(crate) out: PathBuf,
    /// Print a summary as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Strokes by who pulls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Muscle {
    /// The muscle's motor pulls the cable in
    Active,
    /// The load pulls it out
    Passive,
    /// Whole cycles
    Both,
}

/// Ways to compensate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum CompensationKind {
    /// The drive pulls with what is wanted at the far end
    None,
    /// One friction angle and a pretension
    Capstan,
    /// The paper's network
    Paper,
    /// The cable observer
    Observer,
}

/// Play with a simulated cable.
#[derive(Debug, Args)]
pub(crate) struct TwinArguments {
    #[command(subcommand)]
    pub(crate) verb: TwinVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum TwinVerb {
    Cable(TwinCableArguments),
}

/// Move both ends of one cable and see its tensions and its slip front.
///
/// SCENARIO.csv has a row per corner with the columns time_s, motor_m and anchor_m (positions, + toward the motor);
/// between corners both ends move evenly. Without it: pull, hold, yield until slack, pull again.
///
/// Example: sinew twin cable --out cable.csv --picture cable.svg
#[derive(Debug, Args)]
pub(crate) struct TwinCableArguments {
    /// What both ends do
    #[arg(value_name = "SCENARIO.csv")]
    pub(crate) scenario: Option<PathBuf>,
    /// Cable: bench, ideal, or a number to draw another one by
    #[arg(long, value_name = "NAME|N", default_value = "bench")]
    pub(crate) specimen: String,
    /// Far tension at the start, after a pull toward the motor, N
    #[arg(long, value_name = "N", default_value_t = 40.0)]
    pub(crate) start: f64,
    /// Log to write (CSV), a row per millisecond
    #[arg(long, value_name = "LOG")]
    pub(crate) out: PathBuf,
    /// Also draw tensions, their profile along the cable and the slip front
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) picture: Option<PathBuf>,
}

/// Tensions of muscles for given joint torques, within limits, at least cost.
///
/// FILE.json has a list of problems: {"problems":[{"moment_arms":[[..]],"torque_nm":[..],"min_n":[..],"max_n":[..],
/// "reference_n":[..],"weight":[..]}]}; moment_arms is muscles x joints in m, reference_n (0) and weight (1) may be left
/// out. Each gets the tensions that minimise the weighted squares of tension minus reference, or, where no tensions
/// give the torque, those of least cost that come closest to it in N m. --json prints {"solutions":[{"status",
/// "tension_n","residual_nm","iterations","seconds"}]}; seconds are of checking and solving one problem from nothing.
#[derive(Debug, Args)]
pub(crate) struct TensionArguments {
    /// Problems to solve
    #[arg(value_name = "FILE.json")]
    pub(crate) problems: PathBuf,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Motor, reducer and winch of a muscle.
#[derive(Debug, Args)]
pub(crate) struct DriveArguments {
    #[command(subcommand)]
    pub(crate) verb: DriveVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum DriveVerb {
    Size(DriveSizeArguments),
}

/// Find motor, reducer, ratio and winch for what a cable is wanted to do, and what such a drive can do at most.
///
/// The tension can be held for ever while the cable is taken up at the speed; the acceleration comes on top for a
/// moment, with the amplifier's peak current and a hot winding. Of every motor with every reducer the ratio and winch
/// with most to spare are shown: first those that can, the lightest first; then those that cannot, the one that lacks
/// least first. "ratios" is where any ratio would do; "used" the share of the limit
/// that is nearest. The envelope below is the first one's.
///
/// Example: sinew drive size --tension 250 --speed 0.14 --acceleration 3 --stroke 0.3
#[derive(Debug, Args)]
pub(crate) struct DriveSizeArguments {
    /// Tension to hold for ever, N
    #[arg(long, value_name = "N")]
    pub(crate) tension: f64,
    /// Speed of the cable under that tension, m/s
    #[arg(long, value_name = "V")]
    pub(crate) speed: f64,
    /// Acceleration of the cable on top, m/s^2
    #[arg(long, value_name = "A")]
    pub(crate) acceleration: f64,
    /// Cable that the drum must take, m
    #[arg(long, value_name = "M")]
    pub(crate) stroke: f64,
    /// Motors, reducers and winches to choose from instead of the embedded ones
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) catalogue: Option<PathBuf>,
    /// Print the result as JSON for programs
    #[arg(long)]
    pub(crate) json: bool,
}
