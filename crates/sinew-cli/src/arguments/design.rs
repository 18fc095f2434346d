//! Arguments of `sinew design`.

use super::values::number;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Design a machine: size its drives, distribute joint torques over its muscles, study many designs.
#[derive(Debug, Args)]
pub(crate) struct DesignArguments {
    #[command(subcommand)]
    pub(crate) verb: DesignVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum DesignVerb {
    Drive(DriveArguments),
    Tension(TensionArguments),
    Study(StudyArguments),
}

/// Distribute joint torques over muscle tensions within limits at minimum cost.
///
/// FILE.json has a list of problems:
/// {"problems":[{"moment_arms":[[..]],"torque_nm":[..],"min_n":[..],"max_n":[..],
/// "reference_n":[..],"weight":[..]}]}; moment_arms is muscles x joints in m; reference_n (0) and weight (1)
/// are optional. Each solution minimises the weighted squares of tension minus reference subject to the
/// torque; where no tensions within the limits give the torque, it has the least cost among those closest to
/// it in N m, and the program ends with code 3.
#[derive(Debug, Args)]
pub(crate) struct TensionArguments {
    /// Problems to solve
    #[arg(value_name = "FILE.json")]
    pub(crate) problems: PathBuf,
}

/// Select motor, reducer, ratio and winch for required cable motion, and compute the limits of such a drive.
///
/// The drive must hold the tension continuously while it winds at the speed; the acceleration is required in
/// addition for a short time, with the amplifier's peak current and a hot winding. For every pair of motor
/// and reducer the ratio and winch with the largest margin are listed: first the pairs that meet the
/// requirement, lightest first; then the others, smallest deficit first. "ratios" is the interval of ratios
/// that meet it; "used" the fraction of the nearest limit. The envelope below the table is that of the first
/// pair.
///
/// Example: sinew design drive --tension 250 --speed 0.14 --acceleration 3 --stroke 0.3
#[derive(Debug, Args)]
pub(crate) struct DriveArguments {
    /// Continuous tension, N
    #[arg(long, value_name = "N", value_parser = number("a number > 0, N", |n| n > 0.0))]
    pub(crate) tension: f64,
    /// Cable speed under that tension, m/s
    #[arg(long, value_name = "V", value_parser = number("a number >= 0, m/s", |v| v >= 0.0))]
    pub(crate) speed: f64,
    /// Additional cable acceleration, m/s^2
    #[arg(long, value_name = "A", value_parser = number("a number >= 0, m/s^2", |a| a >= 0.0))]
    pub(crate) acceleration: f64,
    /// Cable length that the drum takes up, m
    #[arg(long, value_name = "M", value_parser = number("a number >= 0, m", |m| m >= 0.0))]
    pub(crate) stroke: f64,
    /// Motors, reducers and winches to select from [default: the built-in catalogue]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) catalogue: Option<PathBuf>,
    /// Drives of the catalogue to select from, such as dynamixel, feetech or moteus [default: motors that
    /// belong to none]
    #[arg(long, value_name = "NAME")]
    pub(crate) drives: Option<String>,
}

/// Print the Python program that runs a study: many designs or simulated specimens, on threads, Ray or Slurm.
///
/// The file (TOML) names the objective, the ranges of its parameters, the number of trials and where they
/// run; docs/study.md describes its keys. Running needs the Python package `sinew` (`pip install .`). An
/// interrupted study resumes when its program is started again.
///
/// Example: sinew design study robustness.toml > robustness.py, then python robustness.py
#[derive(Debug, Args)]
pub(crate) struct StudyArguments {
    /// A study
    #[arg(value_name = "FILE.toml")]
    pub(crate) file: PathBuf,
}
