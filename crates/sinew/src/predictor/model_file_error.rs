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

/// Refuses a field that does not hold what is expected of it.
///
/// # Errors
/// [`ModelFileError`] where `holds` is false.
#[expect(clippy::needless_pass_by_value, reason = "callers hand over numbers and texts as they come")]
pub(super) fn require(
    name: &str,
    expected: &str,
    holds: bool,
    got: impl ToString,
) -> Result<(), ModelFileError> {
    if holds {
        return Ok(());
    }
    Err(ModelFileError { name: name.to_string(), expected: expected.to_string(), got: got.to_string() })
}
