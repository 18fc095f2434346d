//! Binary logs: MATLAB v5 always, MATLAB v7.3 and Parquet where they were built in.

mod arrays;
mod mat5;
#[cfg(feature = "mat73")]
mod mat73;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_bounds;
#[cfg(feature = "parquet")]
mod thrift;

pub(super) use arrays::ArrayLog;
pub(super) use mat5::is_mat5;
#[cfg(feature = "parquet")]
pub(super) use parquet::ParquetLog;

/// Runs a reader of ours or others that may give up by panicking: on a damaged file that is an error too.
///
/// The Parquet reader does so for some page headers that contradict each other, found by fuzzing.
#[cfg(any(feature = "parquet", feature = "mat73"))]
fn guarded<T>(
    file: &str,
    expected: &str,
    read: impl FnOnce() -> Result<T, crate::Error>,
) -> Result<T, crate::Error> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(crate::Error::Malformed {
            file: file.into(),
            line: None,
            expected: expected.into(),
            got: "a damaged one, on which its reader gave up".into(),
        })
    })
}
