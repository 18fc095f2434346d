//! From the logs of a cable transmission to a model of its far end, with its errors on held-out data.
//!
//! Offline code: it may read files, use threads and allocate. The model it makes is a
//! [`sinew::predictor`], which does none of that.

pub mod fit;
pub mod log;
pub mod report;

pub mod adapt;
pub mod cable;
mod calibration;
pub mod compensate;
mod conditioning;
mod estimation;
pub mod evaluate;
pub mod gear;
pub mod geometry;
pub mod identify;
mod outside;
mod select;
mod specimen;
mod training;

mod error;
pub use error::{ColumnRole, Error};
