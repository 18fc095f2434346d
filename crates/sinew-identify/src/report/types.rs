//! What a report shows, as plain data.

use super::headline::Headline;
use crate::fit::classical::{ClassicalFit, Parameter};
use crate::log::{ColumnUse, Condition, Input, LogInfo};
use crate::select::influence::InfluenceRow;
use serde::Serialize;
use sinew::predictor::{Beyond, LoopQuantity};

/// Logs, candidates, errors and recommendations of one identification.
#[derive(Debug, Clone, Serialize)]
pub struct IdentificationReport {
    /// Version of the program that made it.
    pub version: String,
    /// The seed of every random draw.
    pub seed: u64,
    /// The far-side column.
    pub far: String,
    /// Its unit, in which errors are; empty where its name states none.
    pub far_unit: String,
    /// The near-side columns.
    pub inputs: Vec<Input>,
    /// The logs and what was found in them.
    pub logs: Vec<LogInfo>,
    /// What every column was used for; empty where a model fixed the roles.
    pub columns: Vec<ColumnUse>,
    /// Conditions found along which the logs could be split.
    pub conditions: Vec<Condition>,
    /// How the folds were formed, in one sentence: the question the scores answer.
    pub question: String,
    /// Number of folds.
    pub folds: usize,
    /// Range of the far signal over the data that were used (q99.95 - q0.05), in its unit.
    pub far_range: f64,
    /// The error to expect of the model on data like the held-out data.
    pub expected: ExpectedError,
    /// The error to expect beyond the conditions of the logs, side by side.
    pub beyond: Vec<Beyond>,
    /// Changes by which another specimen is noticed; empty where it is not.
    pub specimen: Vec<Noticed>,
    /// Every candidate, in the order of [`Candidate::score`], by which one is chosen.
    pub candidates: Vec<Candidate>,
    /// The influence check, one row per log; empty with fewer than four logs.
    pub influence: Vec<InfluenceRow>,
    /// Classical laws fitted to the same data.
    pub classical: Vec<ClassicalFit>,
    /// The parameters that the logs determine, of one law.
    pub headline: Option<Headline>,
    /// Out-of-fold traces of the chosen model: no sample was predicted by a model that saw its fold.
    pub traces: Vec<Trace>,
    /// Limits of the identification, most important first.
    pub warnings: Vec<String>,
    /// Whether the model is recommended.
    pub grade: Grade,
    /// Where the model can be used, and what to do next: two sentences.
    #[serde(rename = "advice")]
    pub recommendations: [String; 2],
    /// The chosen model, in words and numbers.
    pub chosen: ChosenSummary,
}

/// Error to expect on data like the data that the folds held out.
///
/// The choice among candidates is part of what is scored: on every fold, the error of the candidate that the
/// other folds choose. The smallest error in [`IdentificationReport::candidates`] is smaller by the bias of
/// that choice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedError {
    /// Root mean square error, far unit.
    pub rmse: f64,
    /// The same as % of [`IdentificationReport::far_range`].
    pub percent_of_range: f64,
}

/// A change of the loop of near effort over near motion by which another specimen is noticed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noticed {
    /// What changes.
    pub quantity: LoopQuantity,
    /// Its mean in training, effort over motion where it is the slope, else effort.
    pub mean: f64,
    /// The smallest change that is noticed, in the same unit.
    pub change: f64,
}

/// Whether a model is recommended, from its errors on unseen data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// Clearly better than a constant and than linear regression, on logs that show the hysteresis.
    Use,
    /// Better than a constant, but one of the conditions of [`Use`](Self::Use) does not hold.
    UseWithCare,
    /// Not clearly better than a constant.
    DoNotUse,
}

/// Description of the chosen model.
#[derive(Debug, Clone, Serialize)]
pub struct ChosenSummary {
    /// Its name in [`IdentificationReport::candidates`].
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// Why it was chosen, in a sentence.
    pub reason: String,
    /// Its physical parameters.
    pub parameters: Vec<Parameter>,
    /// Factor from standard deviation to half width of the 95 % band (conformal over the folds).
    pub band_factor: f64,
    /// Numbers stored in the model.
    pub size: usize,
}

/// One candidate of the comparison with its errors on held-out data.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Short name, as accepted by [`Options::models`](crate::identify::Options::models).
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// Whether it was chosen.
    pub chosen: bool,
    /// Whether it is a classical law, which stands beside the models and is never chosen.
    pub law: bool,
    /// Numbers that are fitted, in networks those of all.
    pub size: usize,
    /// Geometric mean of [`fold_rmse`](Self::fold_rmse), far unit: what candidates are compared by.
    pub score: f64,
    /// Root mean square error over all folds, far unit.
    pub rmse: f64,
    /// The same as % of [`IdentificationReport::far_range`].
    pub percent_of_range: f64,
    /// Pearson correlation over all folds.
    pub pearson: f64,
    /// Fraction of samples within the 95 % band, each fold with the factor of the others.
    pub coverage95: f64,
    /// RMSE fold by fold.
    pub fold_rmse: Vec<f64>,
    /// RMSE on the data it was fitted to, for comparison.
    pub rmse_in_sample: f64,
    /// Why it could not be fitted, if so; then the numbers are NaN.
    pub failed: Option<String>,
}

/// Out-of-fold prediction over one sequence, as long as the sequence. Not scored samples are kept and marked.
#[derive(Debug, Clone, Serialize)]
pub struct Trace {
    /// Log name.
    pub log: String,
    /// Trial label or empty.
    pub trial: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// The first effort, or without one the first motion.
    pub near: Vec<f64>,
    /// Name of that signal.
    pub near_name: String,
    /// The other inputs, in the order of [`IdentificationReport::inputs`].
    pub others: Vec<InputTrace>,
    /// Measured far side.
    pub far: Vec<f64>,
    /// Predicted far side.
    pub predicted: Vec<f64>,
    /// Half width of the 95 % band.
    pub half_width: Vec<f64>,
    /// How far the learned correction is trusted, 0 to 1 (1 where the model has no gate).
    pub gate: Vec<f64>,
    /// Speed of the near-side signal, unit/s, causally smoothed.
    pub near_rate: Vec<f64>,
    /// Seconds since the near-side signal last reversed.
    pub since_reversal_s: Vec<f64>,
    /// Whether the sample counted.
    pub scored: Vec<bool>,
}

/// One near-side signal over a sequence.
#[derive(Debug, Clone, Serialize)]
pub struct InputTrace {
    /// Its column.
    pub column: String,
    /// As long as the sequence, in the column's unit.
    pub values: Vec<f64>,
}
