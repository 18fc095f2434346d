//! Arguments of `sinew twin` and `sinew reproduce`.

use super::values::{SpecimenParser, SpecimenText, compensation, number};
use clap::{Args, Subcommand, ValueEnum};
use sinew_lab::{CompensationVariant, paper};
use std::path::PathBuf;

/// Reproduce in simulation the experiments of the paper doi:10.1017/S026357472300005X: tables and figures in
/// DIR/report.html, numbers in DIR/results.json.
///
/// Calibration, identification and compensation on the bench at six speeds, then the arm along its path with
/// every compensation variant; all results are labelled as simulated. --quick takes a minute and is coarser:
/// fewer strokes, no other specimens, a path ten times as fast.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// Part of the paper
    #[arg(long, value_enum, default_value_t = Part::All)]
    pub(crate) part: Part,
    /// Coarser, in a minute
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for report.html and results.json; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Seed of all random numbers: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Parts of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Bench and arm
    All,
    /// Tables I to III, figures 7 to 10
    Bench,
    /// Figures 11 to 13
    Arm,
}

/// Simulate the paper's bench, two drives at the two ends of one cable, and write a log of its sensors, one
/// row per millisecond.
///
/// Without --compensation the muscle's motor performs strokes while the load drive varies the far tension
/// between 40 and 200 N: a log for identification. With --compensation the load drive performs the strokes
/// and the muscle's drive tracks the reference of the far tension, with a compensation calibrated on the same
/// specimen before.
///
/// Example: sinew twin bench --speeds 0.04,0.08 --out bench.csv, then sinew identify bench.csv --out
/// out/cable
#[derive(Debug, Args)]
pub(crate) struct TwinBenchArguments {
    /// Strokes to keep in the log, by their direction
    #[arg(long, value_enum, default_value_t = MuscleStrokes::Both)]
    pub(crate) muscle: MuscleStrokes,
    /// Cable speeds, m/s, 0.005 to 0.15
    #[arg(long, value_name = "V,..", value_delimiter = ',', default_values_t = paper::SPEEDS,
        value_parser = number("0.005 to 0.15 m/s", |v| (0.005..=0.15).contains(&v)))]
    pub(crate) speeds: Vec<f64>,
    /// Seconds at each speed, 1 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0,
        value_parser = number("1 to 3600 s", |s| (1.0..=3600.0).contains(&s)))]
    pub(crate) duration: f64,
    /// Compensation of the transmission losses [default: a calibration run without tracking]
    #[arg(long, value_name = "NAME", value_parser = compensation(&CompensationVariant::BENCH))]
    pub(crate) compensation: Option<CompensationVariant>,
    /// Cable: a named one, or a seed N that draws another one at random
    #[arg(long, value_name = "NAME|N", default_value = "bench", value_parser = SpecimenParser)]
    pub(crate) specimen: SpecimenText,
    /// Seed of the sensor noise and of network training
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Log to write (CSV)
    #[arg(long, value_name = "LOG")]
    pub(crate) out: PathBuf,
}

/// Write a programme of motions for a bench (CSV) that shows what a model needs.
///
/// The motor moves along straight lines between the rows: whole strokes, minor loops of a half, a quarter and
/// a tenth of them at the top and at the bottom, and shrinking ones in the middle, at every speed, with a
/// rest at each reversal. The anchor is held. Times are rounded to 1 us and positions to 1 um.
/// `sinew twin cable PLAN` simulates a cable under it, for at most 3600 s and below 5 m/s.
///
/// Example: sinew twin plan --stroke 0.05 --speeds 0.01,0.05 --out plan.csv
#[derive(Debug, Args)]
pub(crate) struct TwinPlanArguments {
    /// Largest stroke of the motor, m of cable, 0.0001 to 10
    #[arg(long, value_name = "M", default_value_t = 0.05,
        value_parser = number("0.0001 to 10 m", |m| (1e-4..=10.0).contains(&m)))]
    pub(crate) stroke: f64,
    /// Cable speeds, m/s, 0.0001 to 5; two and more show the effect of speed
    #[arg(long, value_name = "V,..", value_delimiter = ',', default_values_t = [0.01, 0.03, 0.1],
        value_parser = number("0.0001 to 5 m/s", |v| (1e-4..=5.0).contains(&v)))]
    pub(crate) speeds: Vec<f64>,
    /// Rest at each reversal, s, 0 to 60
    #[arg(long, value_name = "SECONDS", default_value_t = 0.3,
        value_parser = number("0 to 60 s", |s| (0.0..=60.0).contains(&s)))]
    pub(crate) rest: f64,
    /// Table to write, with the columns time_s, motor_m and anchor_m
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// Strokes by their direction, seen from the muscle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MuscleStrokes {
    /// The muscle's motor winds the cable in
    Active,
    /// The load drive pulls the cable out
    Passive,
    /// Whole cycles
    Both,
}

/// Simulate one cable, alone or on the paper's bench, and plan the motions of a bench.
#[derive(Debug, Args)]
pub(crate) struct TwinArguments {
    #[command(subcommand)]
    pub(crate) verb: TwinVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum TwinVerb {
    Cable(Box<TwinCableArguments>),
    Bench(Box<TwinBenchArguments>),
    Plan(TwinPlanArguments),
}

/// Prescribe the motion of both ends of one cable and compute its tensions and its slip front.
///
/// SCENARIO.csv has one row per corner with the columns time_s, motor_m and anchor_m (positions, + toward the
/// motor); positions are linear between corners. Without it the motor winds in, rests, pays out until the
/// cable is slack, and winds in again.
///
/// Example: sinew twin cable --out cable.csv --picture cable.svg
#[derive(Debug, Args)]
pub(crate) struct TwinCableArguments {
    /// Motion of both ends
    #[arg(value_name = "SCENARIO.csv")]
    pub(crate) scenario: Option<PathBuf>,
    /// Cable: a named one, or a seed N that draws another one at random
    #[arg(long, value_name = "NAME|N", default_value = "bench", value_parser = SpecimenParser)]
    pub(crate) specimen: SpecimenText,
    /// Initial far tension, N, at least the cable's pretension, as after sliding toward the motor
    #[arg(long, value_name = "N", default_value_t = 40.0)]
    pub(crate) start: f64,
    /// Log to write (CSV), one row per millisecond
    #[arg(long, value_name = "LOG")]
    pub(crate) out: PathBuf,
    /// Also draw the tensions, their profile along the cable and the slip front
    #[arg(long, value_name = "FILE.svg", value_parser = super::values::svg)]
    pub(crate) picture: Option<PathBuf>,
}
