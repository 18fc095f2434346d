/// What can be wrong with an experiment.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value refused by the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// Logs of an experiment from which nothing can be identified.
    #[error(transparent)]
    Identification(#[from] sinew_identify::Error),
    /// A part of an experiment that cannot be used, or a run that ended early.
    #[error("{name}: expected {expected}, got {got}")]
    Experiment {
        /// The argument or the run.
        name: &'static str,
        /// What was expected of it.
        expected: &'static str,
        /// What it was.
        got: String,
    },
}

impl Error {
    pub(crate) fn experiment(
        name: &'static str,
        expected: &'static str,
        got: &dyn std::fmt::Display,
    ) -> Self {
        Self::Experiment { name, expected, got: got.to_string() }
    }
}
