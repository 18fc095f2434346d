//! A dataset: roles, sequences, conditions, findings.

use std::path::PathBuf;

pub use sinew::predictor::{Input, Role};

/// Columns by role, as requested; roles left out are assigned by canonical names.
///
/// Inputs are all or nothing: where any of `effort`, `motion`, `anchor` and `given` is set, these are the
/// inputs and no other is added.
#[derive(Debug, Clone, Default)]
pub struct RequestedRoles {
    /// The column to predict.
    pub far: Option<String>,
    /// Near-side tensions or torques.
    pub effort: Vec<String>,
    /// Near-side positions or strokes.
    pub motion: Vec<String>,
    /// Far-end displacement from a joint sensor.
    pub anchor: Option<String>,
    /// Slow quantities.
    pub given: Vec<String>,
    /// Time in seconds.
    pub time: Option<String>,
    /// Trial label: states reset where it changes.
    pub trial: Option<String>,
    /// Condition label: cross-validation holds out one value of it at a time.
    pub group: Option<String>,
    /// Columns to exclude, whatever role their names imply.
    pub ignore: Vec<String>,
}

/// What a column of the logs is used for, and why.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct ColumnUse {
    /// Its name.
    pub column: String,
    /// Its role; `None` where it is left.
    pub role: Option<crate::ColumnRole>,
    /// Its unit by a units row or by the end of its name; empty where neither states one.
    pub unit: String,
    /// Why it has this role, or none.
    pub reason: String,
}

/// Columns by role after they were found in every log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Roles {
    /// The column to predict; `None` where a model only predicts and the log has no far side.
    pub far: Option<String>,
    /// The inputs, in the order effort, motion, anchor, given.
    pub inputs: Vec<Input>,
    /// The time column; `None` means the sample index, which the reader reports.
    pub time: Option<String>,
    /// The trial column.
    pub trial: Option<String>,
    /// The group column the user asked for.
    pub group: Option<String>,
}

/// A stretch of samples over which the states of a model may be carried: one trial, cut at gaps.
///
/// Shapes: `time_s: [n]`, `inputs: [n x roles.inputs]` row-major, `far: [n]`, `scored: [n]`.
#[derive(Debug, Clone)]
pub struct Sequence {
    /// Index into [`Dataset::logs`].
    pub log: usize,
    /// The trial's label, or an empty string.
    pub trial: String,
    /// The row in its file (1-based line number for text) of every sample: `[n]`.
    pub row: Vec<usize>,
    /// Time, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// Near-side signals, as a causal reader would have seen them (spikes and missing cells stay as they are:
    /// NaN).
    pub inputs: Vec<f64>,
    /// Far-side signal as logged; NaN where the cell is empty.
    pub far: Vec<f64>,
    /// Far-side signal to fit: spikes removed with a median that may look ahead (training only).
    pub far_clean: Vec<f64>,
    /// False where the sample is not to be fitted or scored: skipped seconds, missing far side, a spike of
    /// the far side.
    pub scored: Vec<bool>,
    /// Value of each of [`Dataset::conditions`] in this sequence.
    pub condition_values: Vec<String>,
}

/// A column that is constant within every trial (or log) and takes several values: a condition of the
/// experiment, such as a load or a frequency, along which folds are formed.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Condition {
    /// Column name.
    pub column: String,
    /// Its values, in order of appearance.
    pub values: Vec<String>,
}

/// What the reader found and did in one log, for the report.
#[derive(Debug, Clone, serde::Serialize)]
pub struct LogInfo {
    /// File name without folders (unique: folders are added where two files share it).
    pub name: String,
    /// Samples kept.
    pub samples: usize,
    /// Trials found.
    pub trials: usize,
    /// Seconds from first to last sample, summed over the sequences.
    pub duration_s: f64,
    /// Median sampling interval, s.
    pub interval_s: f64,
    /// Findings in plain words: gaps, spikes, repeated rows, irregular sampling, duplicated logs.
    pub findings: Vec<String>,
}

/// Every log, checked and cut into sequences.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The columns used.
    pub roles: Roles,
    /// What every column is used for, by role and name; empty where a model fixes the roles.
    pub columns: Vec<ColumnUse>,
    /// One entry per file.
    pub logs: Vec<LogInfo>,
    /// Conditions found in the logs.
    pub conditions: Vec<Condition>,
    /// The samples.
    pub sequences: Vec<Sequence>,
}

/// How to read.
#[derive(Debug, Clone)]
pub struct ReadOptions {
    /// Seconds at the start of every trial that are neither fitted nor scored.
    pub skip_s: f64,
    /// Whether the far column must be there.
    pub far_required: bool,
    /// Paths of the logs.
    pub paths: Vec<PathBuf>,
}
