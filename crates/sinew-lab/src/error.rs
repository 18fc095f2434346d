/// Errors of experiments.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value outside the domain of the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// Logs that do not determine a model.
    #[error(transparent)]
    Identification(#[from] sinew_identify::Error),
    /// Observations of a camera that do not determine a geometry.
    #[error(transparent)]
    Geometry(#[from] sinew_identify::geometry::GeometryError),
    /// An invalid part of an experiment, or a run that ended early.
    #[error("{name}: expected {expected}, got {got}")]
    Experiment {
        /// The argument or the run.
        name: &'static str,
        /// The expected value.
        expected: &'static str,
        /// The actual value.
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
