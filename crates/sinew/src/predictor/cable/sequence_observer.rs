//! The observer of a model's cable along one sequence of its input rows.

use super::model::{CableColumns, ObservedCable};
use super::observer_state::CableEstimate;
use super::single::{CableObserver, CablePlace};

/// An observer with the columns of the inputs that it takes.
#[derive(Debug, Clone)]
pub(in crate::predictor) struct SequenceObserver {
    observer: CableObserver,
    columns: CableColumns,
    /// Innovation of the last row, N.
    pub(in crate::predictor) innovation: f64,
}

impl SequenceObserver {
    /// `None` for a model outside its domain; validation has refused it before.
    pub(in crate::predictor) fn new(cable: &ObservedCable) -> Option<Self> {
        let observer = CableObserver::new(&cable.model).ok()?;
        Some(Self { observer, columns: cable.columns, innovation: 0.0 })
    }

    /// Estimate from a row, `dt_s` after the one before; the first row of a sequence starts the observer.
    #[inline]
    pub(in crate::predictor) fn step(&mut self, started: bool, dt_s: f64, inputs: &[f64]) -> CableEstimate {
        if !started {
            self.observer.reset();
        }
        let estimate = self.observer.step(dt_s, &self.columns.sample(inputs));
        self.innovation = estimate.innovation;
        estimate
    }

    /// Newtons per unit of the near tension's column.
    pub(in crate::predictor) fn tension_scale(&self) -> f64 {
        self.columns.tension_scale
    }

    /// Where the cable is; none before the first row.
    pub(in crate::predictor) fn place(&self) -> Option<CablePlace> {
        self.observer.place()
    }

    /// Takes over the state of an observer of the same model; nothing is allocated.
    pub(in crate::predictor) fn copy_state(&mut self, from: &Self) {
        self.observer.copy_state(&from.observer);
        self.innovation = from.innovation;
    }
}
