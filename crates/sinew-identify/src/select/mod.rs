//! Which model to believe: folds that mimic the question, members that answer it, logs that spoil it.

pub(crate) mod folds;
pub(crate) mod influence;
pub(crate) mod judge;
pub(crate) mod zoo;
