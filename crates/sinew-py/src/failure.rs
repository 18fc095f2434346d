//! Errors of the libraries as Python exceptions, with their own messages.

use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyRuntimeError, PyValueError,
};
use sinew_lab::machine_file::{MachineFileError, TextFileError};
use std::io;

/// Why a call failed; made without the interpreter, so that threads of Rust can return it.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Input that was refused.
    Refused(String),
    /// A file that cannot be read.
    Unreadable(String, io::ErrorKind),
    /// A mistake of this package.
    Internal(String),
}

impl Failure {
    pub(crate) fn refused(message: impl Into<String>) -> Self {
        Self::Refused(message.into())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Refused(message) => PyValueError::new_err(message),
            Failure::Internal(message) => PyRuntimeError::new_err(message),
            Failure::Unreadable(message, kind) => match kind {
                io::ErrorKind::NotFound => PyFileNotFoundError::new_err(message),
                io::ErrorKind::PermissionDenied => PyPermissionError::new_err(message),
                io::ErrorKind::IsADirectory => PyIsADirectoryError::new_err(message),
                _ => PyOSError::new_err(message),
            },
        }
    }
}

impl From<sinew::Error> for Failure {
    fn from(error: sinew::Error) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<sinew::description::DescriptionError> for Failure {
    fn from(error: sinew::description::DescriptionError) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<sinew::predictor::ModelFileError> for Failure {
    fn from(error: sinew::predictor::ModelFileError) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<sinew_identify::Error> for Failure {
    fn from(error: sinew_identify::Error) -> Self {
        let message = error.to_string();
        match error {
            sinew_identify::Error::Unreadable { source, .. } => Self::Unreadable(message, source.kind()),
            _ => Self::Refused(message),
        }
    }
}

impl From<sinew_lab::Error> for Failure {
    fn from(error: sinew_lab::Error) -> Self {
        match error {
            sinew_lab::Error::Identification(error) => error.into(),
            other => Self::Refused(other.to_string()),
        }
    }
}

impl From<MachineFileError> for Failure {
    fn from(error: MachineFileError) -> Self {
        let message = error.to_string();
        match error {
            MachineFileError::Text(TextFileError::Unreadable { source, .. }) => {
                Self::Unreadable(message, source.kind())
            }
            _ => Self::Refused(message),
        }
    }
}

impl From<sinew_report::error::Error> for Failure {
    fn from(error: sinew_report::error::Error) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Self::Internal(format!("a result could not be written as JSON: {error}"))
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Refused(message) | Self::Unreadable(message, _) | Self::Internal(message) => {
                f.write_str(message)
            }
        }
    }
}
