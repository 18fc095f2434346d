//! Binary logs: MATLAB v5 always, MATLAB v7.3 and Parquet where they were built in.

mod arrays;
mod mat5;
#[cfg(feature = "mat73")]
mod mat73;
#[cfg(feature = "parquet")]
mod parquet;

pub(super) use arrays::ArrayLog;
pub(super) use mat5::is_mat5;
#[cfg(feature = "parquet")]
pub(super) use parquet::ParquetLog;
