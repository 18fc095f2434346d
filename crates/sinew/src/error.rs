/// Why a value given to this crate was refused.
///
/// Every variant gives the name of the quantity, what was expected and what was given. The type is `Copy` and
/// holds no text of its own, so that a control loop can return it without allocation; errors of files and of
/// robot descriptions, which quote the file, are types of their own: [`PartError`](crate::body::PartError),
/// [`ModelFileError`](crate::predictor::ModelFileError), `description::DescriptionError`.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
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
    /// An entry of a slice outside its domain.
    #[error("{name}[{index}] must be {expected}, but is {got}")]
    EntryOutOfDomain {
        /// The argument or parameter.
        name: &'static str,
        /// Index of the entry, from 0.
        index: usize,
        /// Domain of the entry in words.
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
    /// A part of a valid robot that the computation cannot use.
    #[error("{kind} number {index}: {field} must be {expected}")]
    Part {
        /// Kind of part: `body`, `joint`, `muscle`.
        kind: &'static str,
        /// Index in the list of its kind, from 0.
        index: usize,
        /// The property that cannot be used.
        field: &'static str,
        /// What the computation requires of it.
        expected: &'static str,
    },
    /// A number of a part of a valid robot or machine outside the domain of a law.
    #[error("{kind} number {index}: {field} must be {expected}, but is {got}")]
    PartOutOfDomain {
        /// Kind of part: `body`, `joint`, `muscle`.
        kind: &'static str,
        /// Index in the list of its kind, from 0.
        index: usize,
        /// The quantity.
        field: &'static str,
        /// Its domain in words.
        expected: &'static str,
        /// The value that was given.
        got: f64,
    },
}

impl Error {
    /// The same as one of a part, where it names a single number.
    pub(crate) fn of_part(self, kind: &'static str, index: usize) -> Self {
        match self {
            Self::OutOfDomain { name, expected, got } => {
                Self::PartOutOfDomain { kind, index, field: name, expected, got }
            }
            other => other,
        }
    }
}

/// `value` if it is finite.
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

/// `value` if the condition `holds`, which `expected` states in words.
pub(crate) fn within(
    name: &'static str,
    expected: &'static str,
    value: f64,
    holds: bool,
) -> Result<f64, Error> {
    if holds { Ok(value) } else { Err(Error::OutOfDomain { name, expected, got: value }) }
}

/// Checks the number of entries of a slice.
#[inline]
pub(crate) fn check_length(name: &'static str, got: usize, expected: usize) -> Result<(), Error> {
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}

/// Checks that a slice has `count` entries, all finite.
#[inline]
pub(crate) fn check_entries(name: &'static str, values: &[f64], count: usize) -> Result<(), Error> {
    check_length(name, values.len(), count)?;
    if all_finite(values) {
        return Ok(());
    }
    let index = values.iter().position(|value| !value.is_finite()).unwrap_or(0);
    let got = values.get(index).copied().unwrap_or(f64::NAN);
    Err(Error::EntryOutOfDomain { name, index, expected: "finite", got })
}

/// Whether every entry is finite: `0 x` is 0 for a finite `x` and NaN otherwise, and NaN stays in a sum.
#[inline]
fn all_finite(values: &[f64]) -> bool {
    // Independent partial sums shorten the chain of dependent additions.
    let fours = values.chunks_exact(4);
    let mut rest = 0.0;
    for value in fours.remainder() {
        rest += value * 0.0;
    }
    let [mut a, mut b] = [0.0, 0.0];
    for four in fours {
        a += four[0] * 0.0 + four[1] * 0.0;
        b += four[2] * 0.0 + four[3] * 0.0;
    }
    (a + b + rest).abs() < 1.0
}
