//! The cable observer's numbers from a log with both ends' displacements and both ends' tensions.
//!
//! The far tension is needed here and nowhere else: once identified, a [`CableObserver`] runs on
//! motor position, anchor displacement and near tension.

mod dataset;
mod fit;
mod observed;
mod quantity;
mod run;
mod start;

pub use dataset::cable_logs;
pub use fit::{CableFit, FitOptions, fit_cable};
pub(crate) use observed::fit_observed;
pub use quantity::{FittedQuantity, Quantity};
pub use run::{CableLog, run_cable};
pub use start::{find_cable, start_from};

#[cfg(doc)]
use sinew::predictor::CableObserver;
