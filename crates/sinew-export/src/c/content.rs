//! What is exported of a model.

use sinew::compensator::CompensatorSettings;

/// What the sources can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Content {
    /// Predict the far end.
    Predictor,
    /// The same, and command the near side for a desired far end, as
    /// [`Compensator`](sinew::compensator::Compensator) does with these settings.
    Compensator(CompensatorSettings),
}
