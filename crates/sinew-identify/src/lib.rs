//! From the logs of a cable transmission to a model of its far end, with an honest account of the fit.
//!
//! Offline code: it may read files, use threads and allocate. The model it makes is a
//! [`sinew::predictor`], which does none of that.

pub mod account;
pub mod fit;
pub mod log;
#[doc(hidden)]
pub mod member;

pub mod adapt;
pub mod evaluate;
pub mod identify;
pub mod observer;
mod runs;
mod select;

mod error;
pub use error::Error;
