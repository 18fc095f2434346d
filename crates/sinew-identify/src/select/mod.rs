//! Which model to believe: folds that mimic the question, members that answer it, logs that spoil it.

pub(crate) mod candidates;
pub(crate) mod cross_validation;
pub(crate) mod folds;
pub(crate) mod influence;
