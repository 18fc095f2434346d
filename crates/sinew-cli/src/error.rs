//! What ends the program with exit code 2.

use std::path::PathBuf;

/// One clear error.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// Between a log and a model.
    #[error(transparent)]
    Identify(#[from] sinew_identify::Error),
    /// An experiment on the twin.
    #[error(transparent)]
    Experiment(#[from] sinew_lab::Error),
    /// A model file that cannot be used.
    #[error("{}: {source}", file.display())]
    Model {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<sinew::predictor::ModelFileError>,
    },
    /// A model that cannot be written or scored.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// A robot file that cannot be used.
    #[error(transparent)]
    Description(Box<sinew::description::DescriptionError>),
    /// A file for a robot that cannot be used.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What and where.
        problem: String,
    },
    /// A flag whose value cannot be used.
    #[error("{flag} {value}: expected {expected}")]
    Argument {
        /// The flag.
        flag: &'static str,
        /// As given.
        value: String,
        /// What would do.
        expected: &'static str,
    },
    /// A path that a robot cannot follow.
    #[error("--path {path}: {obstacle}")]
    Unreachable {
        /// The path as given.
        path: String,
        /// When and why.
        obstacle: String,
    },
    /// A payload that a robot cannot carry along a path.
    #[error("--payload {payload} kg: {obstacle}")]
    Overloaded {
        /// As given.
        payload: f64,
        /// When and why.
        obstacle: String,
    },
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The report could not be made.
    #[error(transparent)]
    Report(#[from] crate::report::error::Error),
    /// JSON could not be made.
    #[error("the result could not be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Standard output is closed.
    #[error("standard output: {0}")]
    Stdout(std::io::Error),
    /// Ctrl-C cannot be caught.
    #[error("the interrupt handler could not be set: {0}")]
    Interrupt(#[from] ctrlc::Error),
    /// No sample to score.
    #[error("{0}")]
    Nothing(String),
}

impl From<sinew::description::DescriptionError> for Error {
    fn from(error: sinew::description::DescriptionError) -> Self {
        Self::Description(Box::new(error))
    }
}
