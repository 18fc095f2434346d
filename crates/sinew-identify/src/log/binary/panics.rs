//! Readers of others that panic on a damaged file.

use crate::Error;

/// The result of a reader; a panic becomes [`Error::Malformed`].
///
/// The Parquet reader panics on some page headers that contradict each other, found by fuzzing.
pub(super) fn catch_panic<T>(
    file: &str,
    expected: &str,
    read: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(Error::Malformed {
            file: file.into(),
            line: None,
            expected: expected.into(),
            got: "a damaged one, on which its reader gave up".into(),
        })
    })
}
