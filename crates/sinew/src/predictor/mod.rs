//! Prediction of the far end from near-side samples, one sample at a time.
//!
//! ```text
//! raw sample -> Conditioner -> signals -> Memory (clamp cell, stops, low-passes) -> Estimator -> Prediction
//! ```
//!
//! A [`Model`] is immutable; a [`Predictor`] holds the state of one sequence. Batch and streaming prediction
//! run the same code and agree bit for bit.

mod axis;
mod cable;
mod conditioner;
mod ensemble;
mod estimator;
#[cfg(feature = "model-file")]
mod file;
mod linear;
mod memory;
mod model;
mod model_file_error;
mod signal;
mod specimen;
mod step;
#[cfg(test)]
mod tests;

pub use axis::{Axis, AxisForce, AxisMotion, AxisSlip, Differentiator};
pub(crate) use cable::CablePlace;
pub use cable::{
    CableColumns, CableEstimate, CableModel, CableObserver, CableObservers, CableSample, ObservedCable,
};
pub use conditioner::{Conditioner, InputLimits, MAX_HELD_SAMPLES, MAX_MAGNITUDE, SampleKind};
pub use ensemble::{Ensemble, EnsembleOutput, MEMBERS, PerNetwork};
pub use estimator::{Estimate, Estimator, EstimatorState, FADE, GATE_STRENGTH, Member};
#[cfg(feature = "model-file")]
pub use file::VERSION;
pub use linear::LinearLaw;
pub use memory::{CellOutput, Feature, Memory, MemoryLaw};
pub use model::{Beyond, Input, Model, OffsetVariance, Outside, Provenance, Role};
pub use model_file_error::ModelFileError;
pub use signal::Signal;
pub use specimen::{LoopCheck, LoopQuantity, LoopState, LoopTerm, Loops, SpecimenDeviation, SpecimenMonitor};
pub use step::{Flags, Prediction, Predictor, Sample};
