//! From near-side samples to the far end, one sample at a time.

mod ensemble;
mod memory;
mod signal;

pub use ensemble::{Ensemble, Lanes, MEMBERS, Opinion};
pub use memory::{Cell, CellOutput, Feature, Memory, MemoryLaw, Term};
pub use signal::Signal;
