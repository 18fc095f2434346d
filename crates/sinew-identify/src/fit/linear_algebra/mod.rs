//! Dense symmetric systems, on the calling thread so that results do not depend on the number of threads.
//!
//! The three products that cost time, `J^T J` and the updates of factor and inverse, are those of
//! `fit/tiles.rs`.

mod cholesky;
mod eigen;
mod matrix;

pub(crate) use cholesky::Cholesky;
pub(crate) use eigen::symmetric_eigen;
pub(crate) use matrix::Matrix;

#[cfg(test)]
mod tests;
