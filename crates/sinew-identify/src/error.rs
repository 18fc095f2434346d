use std::fmt;

/// What a column of a log stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ColumnRole {
    /// The signal to predict.
    Far,
    /// Near-side tensions or torques.
    Effort,
    /// Near-side positions or strokes.
    Motion,
    /// Displacement of the far end.
    Anchor,
    /// Slow quantities.
    Given,
    /// Time.
    Time,
    /// Trial label.
    Trial,
    /// Condition label.
    Group,
    /// None, as requested.
    Ignored,
}

impl fmt::Display for ColumnRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Far => "far-end",
            Self::Effort => "effort",
            Self::Motion => "motion",
            Self::Anchor => "anchor",
            Self::Given => "given",
            Self::Time => "time",
            Self::Trial => "trial",
            Self::Group => "group",
            Self::Ignored => "ignored",
        })
    }
}

/// What can be wrong between a log and a model.
///
/// Every variant names the place, what was expected there and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value refused by the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// A model that cannot be used.
    #[error(transparent)]
    Model(#[from] sinew::predictor::ModelFileError),
    /// Samples, or an option about them, that cannot be fitted.
    #[error("{name}: expected {expected}, got {got}")]
    Samples {
        /// The argument, with sample and column where there is one.
        name: String,
        /// What was expected there.
        expected: String,
        /// What stands there.
        got: String,
    },
    /// A name that no candidate model has.
    #[error("no candidate model is named `{name}`; these logs have {}", list(.known))]
    UnknownModel {
        /// The name asked for.
        name: String,
        /// The candidates for these logs.
        known: Vec<String>,
    },
    /// A name that no log has.
    #[error("no log is named `{name}`; the logs are {}", list(.known))]
    UnknownLog {
        /// The name asked for.
        name: String,
        /// The logs.
        known: Vec<String>,
    },
    /// Data that hold too little for a fit.
    #[error("the logs hold too little to fit {what}")]
    NothingFitted {
        /// What was to be fitted.
        what: &'static str,
    },
    /// A role that a computation needs and no column has.
    #[error("no column has the {role} role, expected {expected}")]
    MissingRole {
        /// The role.
        role: ColumnRole,
        /// What its column holds.
        expected: &'static str,
    },
    /// No log was given.
    #[error("no log was given: name at least one file")]
    NoLogs,
    /// The file system refused.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file as it was given.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not what its kind of file should be.
    #[error("{file}{}: expected {expected}, found {got}", at_line(.line))]
    Malformed {
        /// The log.
        file: String,
        /// Line, counted from 1, where there is one.
        line: Option<usize>,
        /// What was expected there.
        expected: String,
        /// What stands there.
        got: String,
    },
    /// A format whose reader is not part of this build.
    #[error(
        "{file} is a {format} file: this build has no reader for it, the cargo feature `{feature}` adds it"
    )]
    FormatNotBuilt {
        /// The log.
        file: String,
        /// The format, for example `Parquet`.
        format: &'static str,
        /// The cargo feature that reads it.
        feature: &'static str,
    },
    /// More than the reader is willing to hold in memory.
    #[error(
        "{file} is too large: it needs about {needed_mb} MB of memory with the columns asked for, \
         the limit over all logs is {limit_mb} MB; split it or thin it out"
    )]
    TooLarge {
        /// The log at which the limit was passed.
        file: String,
        /// Estimated memory over all logs up to this one, MB.
        needed_mb: u64,
        /// The limit, MB.
        limit_mb: u64,
    },
    /// Text where a number should be.
    #[error("{file}, line {line}, column `{column}`: expected a number, found `{value}`")]
    NotANumber {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell, shortened if long.
        value: String,
    },
    /// Neither a number nor a stamp in a column of stamps.
    #[error("{file}, line {line}, column `{column}`: expected a time as in the first row, found `{value}`")]
    NotATime {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell, shortened if long.
        value: String,
    },
    /// No column of time, and no sampling rate.
    #[error(
        "{file}: expected a time column, no name or content has the form of one: name it (--time COL; in \
            Python time=), or state the sampling rate (--rate HZ; in Python rate_hz=); the columns are {}", list(.columns)
    )]
    NoTime {
        /// The log.
        file: String,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// Time that is written with too few digits for its samples.
    #[error(
        "{file}: expected one sample at a time, {simultaneous} of {rows} samples have the time of the one before \
            them and other values: the times have too few digits, or the file has several rows for one moment; \
            count the samples in place of that column if they are evenly spaced (--rate {rate_hz:.4}; in Python \
            rate_hz=)"
    )]
    CoarseTime {
        /// The log.
        file: String,
        /// Samples with the time of the one before them.
        simultaneous: usize,
        /// All samples.
        rows: usize,
        /// Their mean rate, Hz.
        rate_hz: f64,
    },
    /// Time whose unit is not stated and cannot be told.
    #[error(
        "{file}, column `{column}`: expected a unit of time, none is stated and {interval} from sample to \
            sample is unusual for seconds: state it (--units {column}=ms, or s where it is; in Python \
            units=)"
    )]
    UnitOfTime {
        /// The log.
        file: String,
        /// The column.
        column: String,
        /// Median step of its numbers.
        interval: f64,
    },
    /// A unit that is not known.
    #[error("column `{column}`: expected a unit, one of {}, found `{unit}`", .known.join(", "))]
    UnknownUnit {
        /// The column.
        column: String,
        /// The unit asked for.
        unit: String,
        /// Those that are known for it.
        known: Vec<String>,
    },
    /// A column whose unit measures something else than that of the model's column.
    #[error("{file}: column `{column}` is in {unit}, but the model has it in {expected}")]
    OtherUnit {
        /// The log.
        file: String,
        /// The column.
        column: String,
        /// Its unit.
        unit: String,
        /// The unit of the model's column.
        expected: String,
    },
    /// A number of which the decimal mark cannot be told from a thousands separator.
    #[error(
        "{file}, line {line}, column `{column}`: expected a number, found `{value}`, whose mark separates \
            thousands or decimals: write numbers without thousands separators and with a decimal point"
    )]
    AmbiguousNumber {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell, shortened if long.
        value: String,
    },
    /// An infinite number.
    #[error("{file}, line {line}, column `{column}`: expected a finite number, found `{value}`")]
    NotFinite {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell.
        value: String,
    },
    /// A column that is not there.
    #[error("{file} has no column `{column}`{}; its columns are {}", hint(.nearest), list(.columns))]
    MissingColumn {
        /// The log.
        file: String,
        /// The name asked for.
        column: String,
        /// The name that comes nearest, if one is near.
        nearest: Option<String>,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// A column that only some of the logs have.
    #[error(
        "the logs differ: {file} lacks {}, which {other} has; the columns of {file} are {}",
        list(.lacking), list(.columns)
    )]
    ColumnsDiffer {
        /// The log that lacks columns.
        file: String,
        /// A log that has them.
        other: String,
        /// The columns that are lacking.
        lacking: Vec<String>,
        /// The columns of `file`.
        columns: Vec<String>,
    },
    /// A name that stands for two columns.
    #[error("{file} has two columns named `{column}`: rename one of them")]
    SameName {
        /// The log.
        file: String,
        /// The name.
        column: String,
    },
    /// A column with two roles.
    #[error("column `{column}` was given two roles, {first} and {second}, expected one")]
    TwoRoles {
        /// The column.
        column: String,
        /// Its first role.
        first: ColumnRole,
        /// Its second role.
        second: ColumnRole,
    },
    /// No single column to predict.
    #[error("{file}: expected one far-end column, {}; the columns are {}",
        found(.candidates), list(.columns))]
    NoFar {
        /// The log.
        file: String,
        /// Columns whose names fit.
        candidates: Vec<String>,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// Nothing to predict from.
    #[error(
        "{file}: expected near-side columns, none was given and no name has the form of one: effort \
            (tensions or torques), motion (positions or strokes), anchor (far-end displacement) or given \
            (slow quantities); the columns are {}", list(.columns)
    )]
    NoInputs {
        /// The log.
        file: String,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// Several columns that could have a role.
    #[error("{file}: expected one {role} column, {} could each be it", list(.candidates))]
    Ambiguous {
        /// The log.
        file: String,
        /// The role in question.
        role: ColumnRole,
        /// The columns whose names fit.
        candidates: Vec<String>,
    },
    /// Not enough to work with.
    #[error("{place}: expected at least {expected} {what}, found {got}")]
    TooFew {
        /// The log, or the logs.
        place: String,
        /// What is counted.
        what: &'static str,
        /// How many are needed.
        expected: usize,
        /// How many there are.
        got: usize,
    },
    /// A column without a single number.
    #[error("{place}: column `{column}` holds no number at all, every cell is empty or NaN")]
    AllMissing {
        /// The log, or the logs.
        place: String,
        /// The column.
        column: String,
    },
    /// A signal that never changes where it must.
    #[error("{place}: {what} {} {} constant at {}: expected a signal that varies", list(.columns), are(.columns), short(.value))]
    Constant {
        /// The log, or the logs.
        place: String,
        /// Which signal, in words.
        what: &'static str,
        /// The columns.
        columns: Vec<String>,
        /// The value of the first of them.
        value: f64,
    },
    /// Time that decreases within a trial.
    #[error("{file}, line {line}: time runs backwards, from {before} s to {after} s")]
    TimeBackwards {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// Time before, s.
        before: f64,
        /// Time at the line, s.
        after: f64,
    },
    /// Several trials in one file without a label that distinguishes them.
    #[error(
        "{file}, line {line}: time starts again, from {before} s to {after} s, so several trials seem to be \
         stacked; expected a trial column that distinguishes them, or one file per trial"
    )]
    StackedTrials {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// Time before, s.
        before: f64,
        /// Time at the line, s.
        after: f64,
    },
    /// A group that changes where it must not.
    #[error(
        "{file}, line {line}: the group column `{column}` changes from `{before}` to `{after}` within a \
            trial, expected one value per trial"
    )]
    GroupChanges {
        /// The log.
        file: String,
        /// Line or row, counted from 1.
        line: usize,
        /// The group column.
        column: String,
        /// Its value before.
        before: String,
        /// Its value at the line.
        after: String,
    },
    /// A group that separates nothing.
    #[error("the group column `{column}` has the same value `{value}` everywhere, expected at least two")]
    OneGroup {
        /// The group column.
        column: String,
        /// Its only value.
        value: String,
    },
}

impl Error {
    pub(crate) fn samples(
        name: impl Into<String>,
        expected: impl Into<String>,
        got: &dyn fmt::Display,
    ) -> Self {
        Self::Samples { name: name.into(), expected: expected.into(), got: got.to_string() }
    }
}

fn at_line(line: &Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(", line {line}"))
}

fn hint(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(", did you mean `{name}`?"))
}

/// A number without hundreds of zeros.
fn short(value: &f64) -> String {
    if value.abs() < 1e9 { value.to_string() } else { format!("{value:e}") }
}

fn are(names: &[String]) -> &'static str {
    if names.len() == 1 { "is" } else { "are" }
}

fn list(names: &[String]) -> impl fmt::Display + '_ {
    Names(names)
}

fn found(candidates: &[String]) -> String {
    if candidates.is_empty() {
        "no name has the form of one".to_owned()
    } else {
        format!("{} could each be it", Names(candidates))
    }
}

/// Names in backquotes; a long list is cut to what fits on a terminal.
struct Names<'a>(&'a [String]);

impl fmt::Display for Names<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 40;
        for (i, name) in self.0.iter().take(SHOWN).enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}`{name}`")?;
        }
        if self.0.len() > SHOWN {
            write!(f, " and {} more", self.0.len() - SHOWN)?;
        }
        Ok(())
    }
}
