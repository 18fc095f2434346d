//! Everything that a report is made from.

use crate::conditioning::ConditionedLogs;
use crate::select::cross_validation::ScoredCandidate;
use crate::select::folds::Folds;
use crate::select::laws::ScoredLaw;
use sinew::predictor::Model;

/// Results of the stages of an identification.
pub(crate) struct Evidence<'a> {
    /// The logs that were fitted.
    pub(crate) logs: &'a ConditionedLogs,
    /// Every candidate with its cross-validation.
    pub(crate) scored: &'a [ScoredCandidate],
    /// The classical laws on the same folds.
    pub(crate) laws: &'a [ScoredLaw],
    /// Names of the candidates that these logs do not allow, with the reason.
    pub(crate) not_compared: &'a [(String, String)],
    /// Index of the chosen one.
    pub(crate) chosen: usize,
    /// Why it was chosen, in one sentence.
    pub(crate) reason: String,
    /// The chosen candidate fitted to all logs.
    pub(crate) model: &'a Model,
    /// What was held out.
    pub(crate) folds: &'a Folds,
    /// Why another specimen would not be noticed; completes "because".
    pub(crate) not_monitored: Option<String>,
}
