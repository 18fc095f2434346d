//! The plain way to learn a transmission: one hidden layer of tanh nodes, one linear output, the whole data
//! set in every step of Levenberg-Marquardt.
//!
//! ```text
//! y = c + sum_j v_j tanh(b_j + sum_i W_ij x_i)
//! (J^T J / n + mu I) step = -J^T e / n
//! ```
//!
//! [`train`] is the algorithm, `normal` the normal equations in parallel over fixed chunks of samples,
//! `chunk` what one thread does with one chunk, `product` its inner loops, `simd` the arithmetic on vectors.

mod chunk;
mod network;
mod normal;
mod options;
mod product;
mod scale;
mod simd;
mod training;
mod weights;

pub use options::TrainOptions;
pub use training::{End, Training, train};
pub use weights::Weights;

#[cfg(test)]
mod tests;
