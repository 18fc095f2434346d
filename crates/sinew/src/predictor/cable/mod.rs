//! Observer of a cable: the law of the cable, driven by the displacements of both ends, corrected by the near
//! tension.
//!
//! Control and identification use it; the plant does not.

mod many;
mod model;
mod observer_state;
mod one;
mod sequence_observer;

pub use many::CableObservers;
pub use model::{CableColumns, CableModel, CableSample, ObservedCable};
pub use observer_state::CableEstimate;
pub use one::CableObserver;
pub(crate) use one::CablePlace;
pub(super) use sequence_observer::SequenceObserver;
