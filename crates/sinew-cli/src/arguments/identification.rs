//! Arguments of the verbs between logs and models.

use super::values::number;
use clap::{Args, ValueEnum};
use sinew_identify::log::ColumnOptions;
use std::path::PathBuf;

const SKIP: &str = "a finite number of seconds >= 0";

/// Identify a transmission: bench logs in, DIR/model.json and DIR/report.html out.
///
/// A bench log is a table (CSV, TSV, MATLAB v5; Parquet and MATLAB v7.3 in builds with those features) with
/// one row per sample: signals of the near side (the motor's) and the signal of the far end to be predicted.
/// Roles that no flag sets are inferred from column names with unit suffixes: tension_in_n, position_in_m,
/// tension_out_n, anchor_m, time_s, trial. A column whose name implies a motion but which takes only two or
/// three values is a label and gets no role. Time is found by its name in several languages, by stamps such
/// as 2026-03-01T12:00:00.005, or by a unit of time in a row of units; without a time column --rate states
/// the sampling. Every column is listed with its role and the reason before the fit; --dry-run stops there.
/// One of --effort, --motion, --anchor, --given replaces all inputs that names imply: name every input then.
///
/// Candidate models are compared by cross-validation whose folds hold out values of --group; without it,
/// values of conditions found in the logs (a load, a frequency), else whole logs, trials, or intervals of
/// time. Model states are reset at every trial and after every gap.
///
/// Example: sinew identify day1.csv day2.csv --far tension_out_n --effort tension_in_n --out out/sheath
#[derive(Debug, Args)]
pub(crate) struct IdentifyArguments {
    /// Bench logs with both ends of the transmission
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArguments,
    #[command(flatten)]
    pub(crate) columns: ColumnArguments,
    /// Seconds at the start of every trial that are neither fitted nor scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = number(SKIP, |s| s >= 0.0))]
    pub(crate) skip: f64,
    /// Logs to keep in the fit although the influence check would exclude them, by name in any order, or all
    #[arg(long, value_name = "LOG,..|all", value_delimiter = ',')]
    pub(crate) keep: Vec<String>,
    /// Print the logs, their columns and the role of each, and stop before the fit
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Candidate models: auto, or names from the report's table, separated by commas
    #[arg(long, value_name = "NAME,..", default_value = "auto", value_delimiter = ',')]
    pub(crate) model: Vec<String>,
    /// Which model is chosen: the least error on unseen data, or the fewest parameters within --loss of it
    #[arg(long, value_name = "WHICH", value_enum, default_value_t = PreferArgument::Accurate)]
    pub(crate) prefer: PreferArgument,
    /// Error, in % of the far end's range, that --prefer simple may cost
    #[arg(long, value_name = "PERCENT", default_value_t = 0.5, value_parser = number("a finite number >= 0", |x| x >= 0.0))]
    pub(crate) loss: f64,
    /// Folder for model.json and report.html; created if missing
    #[arg(long, value_name = "DIR", required_unless_present = "dry_run")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}

/// Which model is chosen.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum PreferArgument {
    /// The least error
    Accurate,
    /// The fewest parameters
    Simple,
}

/// What the files do not say of their columns.
#[derive(Debug, Args)]
pub(crate) struct ColumnArguments {
    /// Columns that have another name in some logs: OLD in the file is read as NEW
    #[arg(long, value_name = "OLD=NEW,..", value_delimiter = ',', value_parser = pair)]
    pub(crate) rename: Vec<(String, String)>,
    /// Units of columns, whatever their names say: N, mm, ms and so on; numbers in another unit than the
    /// first log's or the model's are converted
    #[arg(long, value_name = "COL=UNIT,..", value_delimiter = ',', value_parser = pair)]
    pub(crate) units: Vec<(String, String)>,
    /// Samples per second of logs without a time column
    #[arg(long, value_name = "HZ", value_parser = number("a finite number > 0", |hz| hz > 0.0))]
    pub(crate) rate: Option<f64>,
}

impl ColumnArguments {
    /// As the reader takes them.
    pub(crate) fn options(&self) -> ColumnOptions {
        ColumnOptions { rename: self.rename.clone(), units: self.units.clone(), rate_hz: self.rate }
    }
}

/// `COL=VALUE`; a name may hold an equals sign, a value does not.
fn pair(text: &str) -> Result<(String, String), String> {
    match text.rsplit_once('=').map(|(name, value)| (name.trim(), value.trim())) {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((name.to_owned(), value.to_owned()))
        }
        _ => Err("expected a column, an equals sign and what it is, such as force=N".to_owned()),
    }
}

/// A reading of the far end.
#[derive(Debug, Args)]
pub(crate) struct ReadingArguments {
    /// Seconds after the start of every trial at which its far end is read once, as a homing or a stop gives
    /// it: the far column holds the reading, and later predictions are moved by its error, shrunken by what
    /// the model's folds say of offsets
    #[arg(long, value_name = "SECONDS", value_parser = number(SKIP, |s| s >= 0.0))]
    pub(crate) anchor_reading: Option<f64>,
}

/// Columns by role.
#[derive(Debug, Args)]
pub(crate) struct RoleArguments {
    /// Far-end signal to predict
    #[arg(long, value_name = "COL")]
    pub(crate) far: Option<String>,
    /// Tensions (N) or torques (N m) of the near side; replaces all inputs taken by name
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) effort: Vec<String>,
    /// Positions or strokes of the near side (m, mm, rad or deg); replaces all inputs taken by name
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) motion: Vec<String>,
    /// Displacement of the far end (m, mm, rad or deg), from a joint sensor; replaces all inputs taken by
    /// name
    #[arg(long, value_name = "COL")]
    pub(crate) anchor: Option<String>,
    /// Slowly varying quantities: a joint angle, the bend of the sheath; replaces all inputs taken by name
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) given: Vec<String>,
    /// Time: numbers, stamps or durations; the suffixes _s, _ms and _us denote its unit
    #[arg(long, value_name = "COL")]
    pub(crate) time: Option<String>,
    /// Trial label: model states are reset where it changes
    #[arg(long, value_name = "COL")]
    pub(crate) trial: Option<String>,
    /// Condition whose values are the folds of the cross-validation
    #[arg(long, value_name = "COL")]
    pub(crate) group: Option<String>,
    /// Columns to exclude, whatever role their names imply
    #[arg(long, value_name = "COL,..", value_delimiter = ',')]
    pub(crate) ignore: Vec<String>,
}

/// Output of a verb that writes a model.
#[derive(Debug, Args)]
pub(crate) struct WriteArguments {
    /// Also write the hysteresis loop and a trace as one SVG picture
    #[arg(long, value_name = "FILE.svg", value_parser = super::values::svg)]
    pub(crate) picture: Option<PathBuf>,
    /// Seed of all random numbers: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Evaluate a model on logs: MSE, RMSE, Pearson correlation, % of range, coverage of the 95 % band.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// Logs that contain the far-end signal
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) columns: ColumnArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    /// Seconds at the start of every trial that are not scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = number(SKIP, |s| s >= 0.0))]
    pub(crate) skip: f64,
}

/// Predict the far end of logs, sample by sample and causally, as a real-time predictor does.
///
/// The output has one row per sample: log, trial, time_s, prediction, standard_deviation, gate (weight of the
/// learned correction, 0 to 1) and flags: state_unknown, out_of_range, input_held, reset, other_specimen.
#[derive(Debug, Args)]
pub(crate) struct PredictArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// Logs of the near side
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) columns: ColumnArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    /// File to write
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// Command the near side so that the far end is as desired: the inverse of a model, sample by sample and
/// causally.
///
/// DESIRED has the columns of the model's logs under their names: time, the far end as it is desired, and the
/// inputs that are known, such as the anchor's displacement. The near column, which is commanded, may be left
/// out: the drive is then taken to follow. Where it is there, it is what was measured, and the model's state
/// follows it. For the observer of a cable the command is the motor's position, and a near tension that is
/// not there is what the model expects.
///
/// The output has the same columns with the command in the near one, and command_low, command_high (the
/// model's 95 % band through the inverse), gate and flags: not_attainable, rate_limited, out_of_range,
/// correction_withdrawn, state_unknown, input_held, reset. Where not_attainable is not set, `sinew predict`
/// on the output gives what is desired.
///
/// Example: sinew compensate out/sheath/model.json desired.csv --max-rate 400 --out command.csv
#[derive(Debug, Args)]
pub(crate) struct CompensateArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// Table of what is desired
    #[arg(value_name = "DESIRED")]
    pub(crate) desired: PathBuf,
    /// Column that is commanded [default: the motor of a cable's observer, else the first tension or torque,
    /// else the first position]
    #[arg(long, value_name = "COL")]
    pub(crate) near: Option<String>,
    /// Largest rate of the command, in its unit per second: what the drive can follow, also across the dead
    /// band [default: of a motor's position its training range in a second; else the largest change that the
    /// model accepts from one sample to the next]
    #[arg(long, value_name = "RATE", value_parser = number("a finite number > 0", |rate| rate > 0.0))]
    pub(crate) max_rate: Option<f64>,
    /// Smallest command [default: the training range, widened by itself; a tension not below 0; a motor's
    /// position has none]
    #[arg(long, value_name = "X", value_parser = number("a finite number", |_| true))]
    pub(crate) min: Option<f64>,
    /// Largest command [default: as for --min]
    #[arg(long, value_name = "X", value_parser = number("a finite number", |_| true))]
    pub(crate) max: Option<f64>,
    /// Error of the far end, in its unit, that is no reason to move: above the noise of what is desired it
    /// keeps the command from crossing the dead band to and fro [default: 2e-7 of the far end's range]
    #[arg(long, value_name = "X", value_parser = number("a finite number >= 0", |x| x >= 0.0))]
    pub(crate) tolerance: Option<f64>,
    /// The motor of a cable's observer crosses its dead band this long before the cable turns, for a motion
    /// that is planned: about the time that it takes at --max-rate; longer is worse [default: causal]
    #[arg(long, value_name = "SECONDS", value_parser = number("a finite number > 0", |s| s > 0.0))]
    pub(crate) preview: Option<f64>,
    #[command(flatten)]
    pub(crate) columns: ColumnArguments,
    /// File to write
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// Adapt a model to another specimen with a short log that contains the far-end signal.
///
/// After an exchange of cable or tool, which `sinew evaluate` and `sinew predict` notice where near effort
/// and motion show it, record a few trials with the far end measured and adapt. The given model is the prior;
/// parameters that the short log does not determine keep their values.
#[derive(Debug, Args)]
pub(crate) struct AdaptArguments {
    /// The model.json of the previous specimen
    pub(crate) model: PathBuf,
    /// Short logs of the new specimen
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) columns: ColumnArguments,
    /// Seconds at the start of every trial that are neither fitted nor scored
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = number(SKIP, |s| s >= 0.0))]
    pub(crate) skip: f64,
    /// Folder for model.json and report.html; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}

/// Identify a simulated transmission; no log is needed.
///
/// A model is fitted to four simulated days and evaluated on a fifth. The logs are written beside the model;
/// all outputs are labelled as simulated.
#[derive(Debug, Args)]
pub(crate) struct DemoArguments {
    /// Folder for the logs, model.json and report.html; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) write: WriteArguments,
}
