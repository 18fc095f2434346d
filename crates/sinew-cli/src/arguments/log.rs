//! Arguments of `sinew log`.

use super::machine::RootArgument;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Show, convert or draw the recording of a run, or run the controller again over it.
#[derive(Debug, Args)]
pub(crate) struct LogArguments {
    #[command(subcommand)]
    pub(crate) verb: LogVerb,
}

// The help of a subcommand is the documentation comment of its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum LogVerb {
    Info(LogInfoArguments),
    Export(LogExportArguments),
    Plot(LogPlotArguments),
    Replay(ReplayArguments),
    Layout(LogLayoutArguments),
}

/// Show what a recording holds: machine, motion, cycles, faults, size, attachments.
///
/// A recording whose program was killed is read up to its last whole chunk.
///
/// Example: sinew log info run.mcap
#[derive(Debug, Args)]
pub(crate) struct LogInfoArguments {
    /// A recording
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
}

/// Write the cycles of a recording as a table: CSV, or Parquet where the program was built with it; or as a
/// bag of ROS 2.
///
/// Column names end with units, and with the muscle or joint that they belong to. With --muscle the table
/// holds one transmission under the names that `sinew identify` knows: tension_in_n, position_in_m, anchor_m,
/// and of a simulated machine tension_out_n, every 20 ms.
///
/// A bag (MCAP with CDR, beside a metadata.yaml) has /joint_states, /tf, /diagnostics and every signal:
/// /sinew/cycle, /sinew/joints, /sinew/muscles. No ROS is needed to write it.
///
/// Example: sinew log export run.mcap --muscle biceps --out biceps.csv
#[derive(Debug, Args)]
pub(crate) struct LogExportArguments {
    /// A recording
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// What to write
    #[arg(long, value_enum, value_name = "FORM", default_value = "table")]
    pub(crate) to: LogForm,
    /// Table to write, ending in .csv or .parquet; or the folder of a bag, which must not exist
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) out: PathBuf,
    /// One row or message every N cycles [default: 1 in a table, 20 ms in a bag]; what is recorded every 20
    /// ms needs a multiple of that
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000),
        conflicts_with = "muscle")]
    pub(crate) every: Option<u64>,
    /// Only the transmission of one muscle
    #[arg(long, value_name = "NAME")]
    pub(crate) muscle: Option<String>,
}

/// What an export gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogForm {
    /// A table
    Table,
    /// A bag of ROS 2
    Ros2,
}

/// Draw a recording: end point, joints, tensions, commands and times of the cycle.
///
/// The table (CSV) of a simulated run is drawn as the report of that run.
///
/// Example: sinew log plot run.mcap --report run.html
#[derive(Debug, Args)]
pub(crate) struct LogPlotArguments {
    /// A recording, or the table of a simulated run
    #[arg(value_name = "FILE.mcap|RECORD.csv")]
    pub(crate) file: PathBuf,
    /// HTML report to write
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: PathBuf,
}

/// Write a layout with which Foxglove shows a recording: the machine in 3-D, its signals, its states.
///
/// Example: sinew log layout run.mcap --out layout.json
#[derive(Debug, Args)]
pub(crate) struct LogLayoutArguments {
    /// A recording
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// Layout to write
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: PathBuf,
}

/// Run the controller again over the readings of a recording, and show where its commands differ.
///
/// The same build commands bit-identical. With --machine or --gains the commands of another controller
/// are compared with those of the recorded one, cycle by cycle, over the same readings.
///
/// Example: sinew log replay run.mcap --gains softer.json --report differences.html
#[derive(Debug, Args)]
pub(crate) struct ReplayArguments {
    /// A recording
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// Another machine file or built-in machine for the controller
    #[arg(long, value_name = "MACHINE")]
    pub(crate) machine: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Other gains (JSON, as `sinew machine tune` writes them)
    #[arg(long, value_name = "FILE.json")]
    pub(crate) gains: Option<PathBuf>,
    /// Write a page with the commands of both
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}
