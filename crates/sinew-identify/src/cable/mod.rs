//! The cable observer's numbers from a log with both ends' displacements and both ends' tensions.
//!
//! The far tension is needed here and nowhere else: once identified, a [`CableObserver`] runs on
//! motor position, anchor displacement and near tension.

mod candidate;
mod dataset;
mod fit;
mod initial;
mod log;
mod quantity;
mod warming;
mod weakening;

pub(crate) use candidate::fit_observed;
pub use dataset::cable_logs;
pub(crate) use dataset::far_scale;
pub use fit::{CableFit, FitOptions, fit_cable, fit_cable_model};
pub use initial::{identify_cable, initial_cable};
pub use log::{CableLog, observe_log};
pub use quantity::{FittedQuantity, INITIAL_WEAKENING, Quantity};
pub use warming::fit_warming;
pub use weakening::fit_weakening;

#[cfg(doc)]
use sinew::predictor::CableObserver;
