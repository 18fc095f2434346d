//! From near-side samples to the far end, one sample at a time.
//!
//! ```text
//! raw sample -> Conditioner -> signals -> Memory (clamp cell, stops, low-passes) -> Estimator -> Prediction
//! ```
//!
//! A [`Model`] is read once and never changes; a [`Predictor`] carries the state of one sequence. Batch and
//! streaming are the same code, so they agree to the bit.

mod cable;
mod conditioner;
mod ensemble;
mod estimator;
mod file;
mod memory;
mod model;
mod model_file_error;
mod signal;
mod step;

pub use cable::{
    CableColumns, CableEstimate, CableModel, CableObserver, CableObservers, CableSample, ObservedCable,
};
pub use conditioner::{Conditioner, InputLimits, MAX_HELD_SAMPLES, MAX_MAGNITUDE, SampleKind};
pub use ensemble::{Ensemble, EnsembleOutput, MEMBERS, PerNetwork};
pub use estimator::{Estimate, Estimator, GATE_STRENGTH};
pub use file::VERSION;
pub use memory::{CellOutput, Feature, Memory, MemoryLaw};
pub use model::{Input, Model, Provenance, Role};
pub use model_file_error::ModelFileError;
pub use signal::Signal;
pub use step::{Flags, Prediction, Predictor, Sample};
