//! Binary logs: MATLAB v5 always, MATLAB v7.3 and Parquet where they were built in.

mod array;
mod arrays;
mod mat5;
#[cfg(feature = "mat73")]
mod mat73;
#[cfg(any(feature = "parquet", feature = "mat73"))]
mod panics;
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
