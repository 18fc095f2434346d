//! The observer inside a memory: physics in place of the clamp cell.

use super::super::memory::CellOutput;
use super::model::{CableColumns, ObservedCable};
use super::one::CableObserver;

/// An observer at work along one sequence.
#[derive(Debug, Clone)]
pub(in crate::predictor) struct Watch {
    observer: CableObserver,
    columns: CableColumns,
    /// Measured minus believed near tension after the last sample, N.
    pub(in crate::predictor) innovation: f64,
}

impl Watch {
    /// `None` where the model is none, which validation has refused before.
    pub(in crate::predictor) fn new(cable: &ObservedCable) -> Option<Self> {
        let observer = CableObserver::new(&cable.model).ok()?;
        Some(Self { observer, columns: cable.columns, innovation: 0.0 })
    }

    /// Takes a row, `dt_s` after the one before; the first of a sequence starts anew.
    #[inline]
    pub(in crate::predictor) fn step(&mut self, started: bool, dt_s: f64, inputs: &[f64]) -> CellOutput {
        if !started {
            self.observer.reset();
        }
        let estimate = self.observer.step(dt_s, &self.columns.sample(inputs));
        self.innovation = estimate.innovation;
        let (state, known) = (estimate.far, estimate.known);
        // Before the cable has slid as a whole, friction may act either way; afterwards nothing is left to guess.
        let (low, high) = if known { (state, state) } else { (estimate.low, estimate.high) };
        CellOutput { state, low: low.min(high), high: high.max(low), known }
    }
}
