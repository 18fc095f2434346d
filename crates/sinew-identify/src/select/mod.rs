//! Model selection: candidates, the influence of each log, folds, cross-validation, choice.

mod axes;
pub(crate) mod candidates;
pub(crate) mod choice;
pub(crate) mod cross_validation;
pub(crate) mod folds;
pub(crate) mod influence;
mod signals;
