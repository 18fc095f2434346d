//! One hidden layer of tanh nodes, one linear output, trained by Levenberg-Marquardt on all samples at once.
//!
//! ```text
//! y = c + sum_j v_j tanh(b_j + sum_i W_ij x_i)
//! (J^T J / n + mu I) step = -J^T e / n
//! ```
//!
//! [`train`] poses the problem, `normal_equations` sums over fixed chunks of samples in parallel with the
//! products of `fit/tiles.rs`.

mod network;
mod normal_equations;
mod samples;
mod training;

pub use network::Weights;
pub use training::{End, TrainOptions, Training, train};

#[cfg(test)]
mod tests;
