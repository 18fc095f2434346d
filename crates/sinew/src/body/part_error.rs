use crate::error::Error;
use alloc::format;
use alloc::string::String;

/// The first invalid part of a robot description.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{kind} {}: {field} must be {expected}, but is {got}", label(name, *index))]
pub struct PartError {
    /// Kind of part: `body`, `joint`, `tendon`...
    pub kind: &'static str,
    /// Index in the list of its kind, from 0.
    pub index: usize,
    /// Its name, empty if it has none.
    pub name: String,
    /// The invalid property.
    pub field: &'static str,
    /// What is required of it.
    pub expected: String,
    /// The value in the description.
    pub got: String,
}

/// A part by its name, or by its index if it has none.
fn label(name: &str, index: usize) -> String {
    if name.is_empty() { format!("number {index}") } else { format!("`{name}`") }
}

/// Kind, index and property remain; the texts do not fit a `Copy` type.
impl From<PartError> for Error {
    fn from(error: PartError) -> Self {
        let PartError { kind, index, field, .. } = error;
        Error::Part { kind, index, field, expected: "valid" }
    }
}
