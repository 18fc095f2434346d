use crate::error::Error;
use alloc::format;
use alloc::string::{String, ToString};

/// A field of a model, or of its file, that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("model file: {name}: expected {expected}, got {got}")]
pub struct ModelFileError {
    /// The field, or `file` for the whole.
    pub name: String,
    /// What is required of it.
    pub expected: String,
    /// Its value.
    pub got: String,
}

impl ModelFileError {
    /// An error about the part of a model that stands in `field`.
    pub(super) fn in_field(field: &str, error: Error) -> Self {
        match error {
            Error::OutOfDomain { name, expected, got } => {
                Self { name: format!("{field}.{name}"), expected: expected.to_string(), got: got.to_string() }
            }
            _ => Self { name: field.to_string(), expected: "valid".to_string(), got: error.to_string() },
        }
    }
}
