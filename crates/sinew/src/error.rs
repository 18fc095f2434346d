use alloc::format;
use alloc::string::String;

/// What can be wrong with a value handed to this crate.
///
/// Every variant names the thing, what was expected of it and what it was.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number outside the domain of a law; NaN and infinities are outside every domain.
    #[error("{name} must be {expected}, but is {got}")]
    OutOfDomain {
        /// The argument or parameter.
        name: &'static str,
        /// Its domain in words, for example `">= 0 N"`.
        expected: &'static str,
        /// The value that was given.
        got: f64,
    },
    /// A slice of the wrong length.
    #[error("{name} must have {expected} entries, but has {got}")]
    WrongLength {
        /// The argument or parameter.
        name: &'static str,
        /// Entries expected.
        expected: usize,
        /// Entries given.
        got: usize,
    },
    /// A model file that cannot be used.
    #[error("model file: {name}: expected {expected}, got {got}")]
    ModelFile {
        /// The field, or `file` for the whole.
        name: String,
        /// What was expected there.
        expected: String,
        /// What stands there.
        got: String,
    },
    /// A robot's part that makes no sense.
    #[error("{kind} {}: {field} must be {expected}, but is {got}", called(name, *index))]
    Part {
        /// What kind of part: `body`, `joint`, `tendon`...
        kind: &'static str,
        /// Its place in the list of its kind, from 0.
        index: usize,
        /// Its name, if it has one.
        name: String,
        /// What about it is wrong.
        field: &'static str,
        /// What was expected there.
        expected: String,
        /// What stands there.
        got: String,
    },
}

/// A part by its name, or by its place when it has none.
fn called(name: &str, index: usize) -> String {
    if name.is_empty() { format!("number {index}") } else { format!("`{name}`") }
}

/// `value` if it is finite, an error that names it otherwise.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, Error> {
    within(name, "a finite number", value, value.is_finite())
}

/// `value` if it is finite and at least zero.
pub(crate) fn non_negative(name: &'static str, value: f64) -> Result<f64, Error> {
    within(name, "a finite number >= 0", value, value.is_finite() && value >= 0.0)
}

/// `value` if it is finite and above zero.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    within(name, "a finite number > 0", value, value.is_finite() && value > 0.0)
}

/// `value` if it `holds` what is `expected` of it.
pub(crate) fn within(
    name: &'static str,
    expected: &'static str,
    value: f64,
    holds: bool,
) -> Result<f64, Error> {
    if holds { Ok(value) } else { Err(Error::OutOfDomain { name, expected, got: value }) }
}
