//! Where plant and controller meet: experiments on the twin. Nothing else may know both.

pub mod arm;
pub mod bench;
mod tally;

pub use tally::{Incident, SETTLING, Spread, TrackSummary};
