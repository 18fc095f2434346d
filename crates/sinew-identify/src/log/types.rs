//! A dataset: roles, sequences, conditions, findings.

use std::collections::BTreeMap;
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
    /// Its unit, as requested, by a units row or by the end of its name; empty where none states one.
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
    /// The time column; `None` where time is counted at [`ColumnOptions::rate_hz`].
    pub time: Option<String>,
    /// The trial column.
    pub trial: Option<String>,
    /// The group column the user asked for.
    pub group: Option<String>,
    /// Units of columns whose names do not state them, where a model fixes the roles.
    pub units: BTreeMap<String, String>,
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

/// What is wrong with a log or one of its channels, beyond what was repaired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// A channel stands at a bound while the others move on.
    Clipped,
    /// A channel stands still and then jumps while the others move.
    Frozen,
    /// Time is in another unit or of another clock.
    Clock,
    /// Too short.
    Short,
    /// Two channels are shifted against each other in time.
    Shifted,
    /// A channel has another gain, offset or sign than in the other logs.
    Gain,
    /// The logs contradict each other.
    Contradiction,
    /// A property changes from log to log in one direction.
    Trend,
}

/// A defect of a log, which makes a model of it doubtful.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Defect {
    /// What it is.
    pub kind: DefectKind,
    /// The channel; empty where it concerns all.
    pub column: String,
    /// The first line, or row of a binary file, from 1; `None` where it concerns the whole log.
    pub line: Option<usize>,
    /// What was found, where, and what it does to the result; without a full stop.
    pub sentence: String,
}

impl Defect {
    /// A defect of a whole log.
    pub(crate) fn of_log(kind: DefectKind, column: &str, sentence: String) -> Self {
        Self { kind, column: column.to_owned(), line: None, sentence }
    }
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
    /// Findings in plain words: gaps, spikes, repeated rows, irregular sampling, duplicated logs; the
    /// sentence of every defect.
    pub findings: Vec<String>,
    /// Defects that make a model of this log doubtful.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub defects: Vec<Defect>,
}

impl LogInfo {
    /// Adds a defect, and its sentence to the findings.
    pub(crate) fn add(&mut self, defect: Defect) {
        self.findings.push(defect.sentence.clone());
        self.defects.push(defect);
    }
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

/// What the files do not say of their columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColumnOptions {
    /// Names in the files and the names to read them under: a column that other days call otherwise.
    pub rename: Vec<(String, String)>,
    /// Columns and their units, whatever names and rows of units say.
    pub units: Vec<(String, String)>,
    /// Samples per second, Hz, above zero: time is counted, and no column of time is read.
    pub rate_hz: Option<f64>,
}

impl Dataset {
    /// The unit of a column, as [`ColumnUse::unit`] or by its name; empty where neither states one.
    #[must_use]
    pub fn unit(&self, column: &str) -> String {
        let stated = self.columns.iter().find(|used| used.column == column).map(|used| used.unit.clone());
        let stated = stated.or_else(|| self.roles.units.get(column).cloned());
        stated.filter(|unit| !unit.is_empty()).unwrap_or_else(|| super::units::unit_of(column))
    }
}

/// How to read.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Seconds at the start of every trial that are neither fitted nor scored.
    pub skip_s: f64,
    /// Whether the far column must be there.
    pub far_required: bool,
    /// Paths of the logs.
    pub paths: Vec<PathBuf>,
    /// What the files do not say of their columns.
    pub columns: ColumnOptions,
    /// Columns that are conditions however many values they take.
    pub conditions: Vec<String>,
}
