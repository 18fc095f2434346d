//! Model selection: candidates, the influence of each log, agreement of logs and channels, folds,
//! cross-validation, choice.

pub(crate) mod agreement;
mod axes;
pub(crate) mod candidates;
pub(crate) mod choice;
pub(crate) mod cross_validation;
pub(crate) mod folds;
mod hypotheses;
pub(crate) mod influence;
pub(crate) mod laws;
pub(crate) mod mean;
mod ranges;
mod signals;
pub(crate) mod trend;
