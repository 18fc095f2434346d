//! The one error of descriptions.

/// The first error in the description of a device: where, the value, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {field}: {problem}")]
pub struct DescriptionError {
    /// Name of the file, or of the device for a description that was not read from a file.
    pub file: String,
    /// Line, from 1; 0 where there is no file.
    pub line: usize,
    /// The field, as `object.0x6040:0.value`.
    pub field: String,
    /// The value and what was expected.
    pub problem: String,
}
