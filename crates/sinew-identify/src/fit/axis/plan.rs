//! What is asked of the fit of an axis, and what it gives.

use sinew::predictor::Axis;

/// The columns of an axis, as indices of signals, and which of its laws is meant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisPlan {
    /// Which law.
    pub kind: AxisKind,
    /// Positions and velocities.
    pub motions: Vec<usize>,
    /// Forces.
    pub efforts: Vec<usize>,
}

/// The laws of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AxisKind {
    /// The far side is a force.
    Force,
    /// The far side is a motion.
    Motion,
}

/// A fitted axis.
#[derive(Debug, Clone)]
pub(crate) struct FittedAxis {
    pub axis: Axis,
    /// Whether its inertia shows: without it the law would be clearly worse.
    pub inertia_shows: bool,
}
