//! From the logs of a cable transmission to a model of its far end, with an honest account of the fit.
//!
//! Offline code: it may read files, use threads and allocate. The model it makes is a
//! [`sinew::predictor`], which does none of that.

pub mod fit;
pub mod log;
pub mod report;
#[doc(hidden)]
pub mod training;

pub mod adapt;
pub mod cable;
mod conditioning;
pub mod evaluate;
pub mod identify;
mod select;

mod error;
pub use error::Error;
