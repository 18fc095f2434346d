//! The cable itself as a model: carried along by both ends' displacements, corrected by the near tension.
//!
//! It stands in this room because control and identification both use it, and the plant may not know it.

mod many;
mod model;
mod one;
mod track;
mod watch;

pub use many::CableObservers;
pub use model::{CableColumns, CableModel, CableSample, ObservedCable};
pub use one::CableObserver;
pub use track::CableEstimate;
pub(super) use watch::Watch;
