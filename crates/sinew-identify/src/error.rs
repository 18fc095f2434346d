/// What can be wrong between a log and a model.
///
/// Every variant names the place, what was expected there and what stands there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value refused by the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
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
}

impl Error {
    pub(crate) fn samples(
        name: impl Into<String>,
        expected: impl Into<String>,
        got: &dyn std::fmt::Display,
    ) -> Self {
        Self::Samples { name: name.into(), expected: expected.into(), got: got.to_string() }
    }
}
