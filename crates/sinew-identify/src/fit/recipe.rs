//! What a candidate model consists of, before it is fitted.

use super::axis::AxisPlan;
use super::cell::CellPlan;
use sinew::predictor::{CableColumns, Signal};

/// The inputs of the networks: which signals, and which memory operators of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct FeaturePlan {
    /// Signals that enter with their stop operators and low-pass differences.
    pub signals: Vec<usize>,
    /// Signals that enter with their present value alone.
    pub plain: Vec<usize>,
    /// Radii of the stop operators as fractions of the signal's range.
    pub radii: Vec<f64>,
    /// Time constants of low-pass differences, s.
    pub taus: Vec<f64>,
    /// Signals that enter with their last rates and the smooth sign of the last.
    pub rates: Vec<usize>,
    /// Signals that enter with their distances from the extremes of their sequence.
    pub loops: Vec<usize>,
    /// Whether `signals` are kept within their range in the training data.
    pub clamped: bool,
    /// Plain signals by which all other features are multiplied, beside themselves.
    pub times: Vec<usize>,
}

/// Samples per independent sample of the residual, counted before thinning: the weight of the data against
/// the prior of the networks; a larger value means stronger regularisation.
///
/// One value for every log: on measured rigs of 400 to 80 000 samples the autocorrelation time of the
/// residuals is 13 to 140 samples, and errors on unseen logs differ by a few per cent between 5 and 50.
pub(crate) const CORRELATION: f64 = 20.0;

/// Everything that determines the fit of one candidate model, apart from the data and the seed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recipe {
    /// Its name in reports.
    pub name: String,
    /// The signals computed from the inputs; every other index refers to this list.
    pub signals: Vec<Signal>,
    /// Structure of its clamp cell; none in a pure network.
    pub cell: Option<CellPlan>,
    /// The cable observer in place of the cell: the columns it reads, and newtons per unit of the far side.
    pub cable: Option<(CableColumns, f64)>,
    /// A moving mass in place of the cell.
    pub axis: Option<AxisPlan>,
    /// Inputs of its networks; none in a purely physical model.
    pub features: Option<FeaturePlan>,
    /// Hidden tanh nodes of each network.
    pub hidden: usize,
    /// Most rows the networks are trained on.
    pub rows: usize,
    /// Most Levenberg-Marquardt steps.
    pub steps: usize,
    /// Networks trained, 2 to [`MEMBERS`](sinew::predictor::MEMBERS): all of them for the final model, half
    /// of them while recipes are compared.
    pub networks: usize,
    /// How the part that is not physical is learned.
    pub learner: Learner,
}

impl Recipe {
    /// Whether the physics of both are fitted alike, so that one law serves both.
    pub(crate) fn shares_physics(&self, other: &Self) -> bool {
        let laws = (&self.cell, &self.cable, &self.axis) == (&other.cell, &other.cable, &other.axis);
        laws && self.signals == other.signals
    }
}

/// How the part that is not physical is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Learner {
    /// An ensemble whose correction is gated by the variance over its networks.
    Ensemble,
    /// Linear regression on the features; without features a constant.
    Linear,
    /// Linear regression on the features, which goes on beyond the training data.
    Regression,
    /// The same, and a gated ensemble on its residual.
    Skeleton,
    /// One network without memory, trained on all rows at once, as in `yuan2023`.
    Paper,
}
