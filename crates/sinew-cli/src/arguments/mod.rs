//! The command line: every argument is parsed into a value within its domain, or refused with a message that
//! names the valid values.
//!
//! The documentation comments of the structures and their fields are the text that `--help` prints.

mod calibrate;
mod can;
mod design;
mod ethercat;
mod export;
mod identification;
mod link;
mod live;
mod log;
mod machine;
mod motion;
mod page;
mod path;
mod ros;
mod run;
mod servos;
mod session;
mod simulation;
mod track;
mod values;
mod verbs;

pub(crate) use calibrate::{
    CalibrateArguments, CalibrateFitArguments, CalibrateFlyArguments, CalibratePlanArguments, CalibrateVerb,
    ScenarioArguments,
};
pub(crate) use can::{CanArguments, CanScanArguments, CanSimulateArguments, CanVerb};
pub(crate) use design::{DesignArguments, DesignVerb, DriveArguments, StudyArguments, TensionArguments};
pub(crate) use ethercat::{
    EthercatArguments, EthercatScanArguments, EthercatSimulateArguments, EthercatVerb,
};
pub(crate) use export::{
    ExportArguments, ExportForm, ExportVerb, MachineExportArguments, ModelExportArguments,
    TwinExportArguments, UnitArguments, UnitForm,
};
pub(crate) use identification::{
    AdaptArguments, CompensateArguments, DemoArguments, EvaluateArguments, IdentifyArguments,
    PredictArguments, PreferArgument, RoleArguments, WriteArguments,
};
pub(crate) use link::{LinkArguments, LinkKeyArguments, LinkVerb, LinkWatchArguments};
pub(crate) use live::LiveArguments;
pub(crate) use log::{
    LogArguments, LogExportArguments, LogForm, LogInfoArguments, LogLayoutArguments, LogPlotArguments,
    LogVerb, ReplayArguments,
};
pub(crate) use machine::{
    MachineArguments, MachineBodyArguments, MachineConvertArguments, MachineEvaluateArguments,
    MachineMapArguments, MachineNewArguments, MachineShowArguments, MachineTuneArguments, MachineVerb,
    Routing,
};
pub(crate) use motion::MotionArguments;
pub(crate) use page::PageArguments;
pub(crate) use path::{PATH_FORMS, PathArgument};
pub(crate) use run::{BusArgument, RunArguments};
pub(crate) use servos::{ServosArguments, ServosScanArguments, ServosSimulateArguments, ServosVerb};
pub(crate) use session::SessionArguments;
pub(crate) use simulation::{
    MuscleStrokes, Part, ReproduceArguments, TwinArguments, TwinBenchArguments, TwinCableArguments,
    TwinPlanArguments, TwinVerb,
};
pub(crate) use track::TrackArguments;
pub(crate) use values::SpecimenText;
pub(crate) use verbs::{command, moved};

use crate::version::version;
use clap::{Args, Parser, Subcommand, ValueEnum};
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
///
/// `sinew completions SHELL` prints completions for a shell, `sinew man` the manual page.
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
    Compensate(CompensateArguments),
    Adapt(AdaptArguments),
    Export(ExportArguments),
    Demo(DemoArguments),
    Example(ExampleArguments),
    Machine(MachineArguments),
    Design(DesignArguments),
    Calibrate(Box<CalibrateArguments>),
    Track(TrackArguments),
    Run(RunArguments),
    Live(LiveArguments),
    Ethercat(EthercatArguments),
    Servos(ServosArguments),
    Can(CanArguments),
    Link(LinkArguments),
    Log(LogArguments),
    Twin(TwinArguments),
    Reproduce(ReproduceArguments),
    Doctor(DoctorArguments),
    #[command(hide = true)]
    Completions(CompletionsArguments),
    #[command(hide = true)]
    Man(ManArguments),
}

/// Write a folder to begin with: its files and three commands to try.
///
/// Without a name, list the examples.
///
/// Example: sinew example hand
#[derive(Debug, Args)]
pub(crate) struct ExampleArguments {
    /// Which one
    #[arg(value_enum)]
    pub(crate) name: Option<ExampleName>,
    /// Folder; created if missing [default: the example's name]
    #[arg(long, value_name = "DIR", requires = "name")]
    pub(crate) out: Option<PathBuf>,
}

/// One for every door.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum ExampleName {
    Bench,
    Hand,
    Training,
    Bus,
}

/// Say what this computer has of what the verbs may need, and what helps where it is missing.
///
/// Real-time scheduling, rights for raw Ethernet frames, a browser, the Python package, MuJoCo and a C
/// compiler are tried, and nothing is changed.
///
/// Example: sinew doctor
#[derive(Debug, Args)]
pub(crate) struct DoctorArguments {}

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
    /// Folder for sinew.1, sinew-identify.1 and so on; created if missing [default: sinew.1 to standard
    /// output]
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
