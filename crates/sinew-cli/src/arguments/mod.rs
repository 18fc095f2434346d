//! The command line: every argument is parsed into a value within its domain, or refused with a message that
//! names the valid values.
//!
//! The documentation comments of the structures and their fields are the text that `--help` prints.

mod design;
mod ethercat;
mod fault;
mod identification;
mod link;
mod live;
mod log;
mod machine;
mod motion;
mod page;
mod path;
mod replay;
mod robot;
mod run;
mod session;
mod simulation;
mod study;
mod values;

pub(crate) use design::{DriveArguments, DriveSizeArguments, DriveVerb, TensionArguments};
pub(crate) use ethercat::{
    EthercatArguments, EthercatScanArguments, EthercatSimulateArguments, EthercatVerb,
};
pub(crate) use fault::{Component, FaultArgument, OFFERED};
pub(crate) use identification::{
    AdaptArguments, DemoArguments, EvaluateArguments, IdentifyArguments, PredictArguments, RoleArguments,
    WriteArguments,
};
pub(crate) use link::{LinkArguments, LinkKeyArguments, LinkVerb, LinkWatchArguments};
pub(crate) use live::LiveArguments;
pub(crate) use log::{
    LogArguments, LogExportArguments, LogInfoArguments, LogLayoutArguments, LogPlotArguments, LogVerb,
};
pub(crate) use machine::{
    MachineArguments, MachineMapArguments, MachineNewArguments, MachineShowArguments, MachineTuneArguments,
    MachineVerb,
};
pub(crate) use motion::MotionArguments;
pub(crate) use page::PageArguments;
pub(crate) use path::{PATH_FORMS, PathArgument};
pub(crate) use replay::ReplayArguments;
pub(crate) use robot::{
    ArmArguments, ArmEvaluateArguments, ArmVerb, ConvertArguments, InspectArguments, TrackArguments,
};
pub(crate) use run::{BusArgument, RunArguments};
pub(crate) use session::SessionArguments;
pub(crate) use simulation::{
    BenchArguments, BenchPlanArguments, BenchRunArguments, BenchVerb, MuscleStrokes, Part,
    ReproduceArguments, TwinArguments, TwinVerb,
};
pub(crate) use study::StudyArguments;

use crate::version::version;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;

/// Last paragraph of `--help`. 1 and 2 come from `Error::exit_code`; 130 = 128 + SIGINT, as in shells.
const EXIT_CODES: &str = "\
Exit codes:
  0    done as asked
  1    the machine that runs the program failed: no permission, no space
  2    bad input: an argument, a file or its content
  3    the input is good and the result is not what was asked for: a motion
       infeasible, stopped (by Ctrl-C, too) or inaccurate, a bench run stopped,
       a cable broken, a torque out of reach, no drive that is strong enough
  130  ended at once by Ctrl-C, SIGTERM or SIGHUP; no output is left incomplete.
       `sinew run` answers the first with a safe stop and the second with
       braked winches, both with code 3; only the third ends it at once, or
       one before drives have power";

/// Identifies, simulates and controls cable-driven robots whose cables run in sheaths.
///
/// The far end of a cable, which carries no sensor in operation, is estimated from the signals of the motor's
/// side.
///
/// Start with `sinew demo --out DIR`, or with a bench log in which both ends are measured:
/// `sinew identify LOG --far COLUMN --effort COLUMN --out DIR`, then open DIR/report.html.
#[derive(Debug, Parser)]
#[command(name = "sinew", version = version(), about, long_about, propagate_version = true, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) general: General,
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// What every verb takes.
#[derive(Debug, Args)]
pub(crate) struct General {
    /// Print the result, or the error, as one JSON document
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Refuse to replace files that exist
    #[arg(long, global = true)]
    pub(crate) no_clobber: bool,
}

// The help of a subcommand is the documentation comment of its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Identify(IdentifyArguments),
    Evaluate(EvaluateArguments),
    Predict(PredictArguments),
    Adapt(AdaptArguments),
    Demo(DemoArguments),
    Arm(ArmArguments),
    Machine(MachineArguments),
    Track(TrackArguments),
    Plot(PlotArguments),
    Run(RunArguments),
    Log(LogArguments),
    Replay(ReplayArguments),
    Ethercat(EthercatArguments),
    Link(LinkArguments),
    Live(LiveArguments),
    Reproduce(ReproduceArguments),
    Bench(BenchArguments),
    Twin(TwinArguments),
    Study(StudyArguments),
    Tension(TensionArguments),
    Drive(DriveArguments),
    Completions(CompletionsArguments),
    Man(ManArguments),
}

/// Draw the report of a run again from what `sinew track` or `sinew run` has recorded of it.
///
/// The record of `sinew track` is a table (CSV): time, status, end point, joints (reference, true, read, estimated),
/// winches (read, commanded), tensions (desired, estimated and true at the anchor, true and read at the drive), one row
/// per 10 ms. The recording of `sinew run` is drawn as by `sinew log plot`.
///
/// Example: sinew plot run.csv --report run.html
#[derive(Debug, Args)]
pub(crate) struct PlotArguments {
    /// A record of `sinew track` or a recording of `sinew run`
    #[arg(value_name = "RECORD.csv|FILE.mcap")]
    pub(crate) record: PathBuf,
    /// HTML report to write
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: PathBuf,
}

/// Print a completion script for a shell.
///
/// Example: sinew completions bash > ~/.local/share/bash-completion/completions/sinew
#[derive(Debug, Args)]
pub(crate) struct CompletionsArguments {
    /// Shell that reads the script
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

/// Print the manual page of the program, or write those of all verbs.
///
/// Example: sinew man --out ~/.local/share/man/man1, then man sinew-identify
#[derive(Debug, Args)]
pub(crate) struct ManArguments {
    /// Folder for sinew.1, sinew-identify.1 and so on; created if missing [default: sinew.1 to standard output]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_of_the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
