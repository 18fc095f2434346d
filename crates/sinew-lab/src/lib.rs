//! Experiments on simulated cable-driven robots: where plant and controller meet, and the only place.
//!
//! A bench and an arm are run on the twin, their cables are calibrated from the logs of those runs, the arm tracks
//! paths, and one paper's programme is repeated. All of its numbers are simulated.

pub mod arm;
pub mod calibrate;
pub mod experiment;
pub mod paper;
pub mod reproduce;
pub mod simulated;

mod error;
mod variant;

pub use error::Error;
pub use variant::CompensationVariant;
