//! Observer of a cable: the law of the cable, driven by the displacements of both ends, corrected by the near
//! tension.
//!
//! Control and identification use it; the plant does not.

mod batch;
mod model;
mod observer_state;
mod sequence_observer;
mod single;

pub use batch::CableObservers;
pub use model::{CableColumns, CableModel, CableSample, ObservedCable};
pub use observer_state::CableEstimate;
pub(super) use sequence_observer::SequenceObserver;
pub use single::CableObserver;
pub(crate) use single::CablePlace;
