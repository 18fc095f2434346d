//! The cable observer as the physics of a model: which columns it reads, and what it makes of them.

use super::memory::CellOutput;
use super::model::require;
use super::observer::{CableModel, CableObserver, CableSample};
use crate::Error;
use alloc::format;
use serde::{Deserialize, Serialize};

/// Which inputs a cable is observed through, and what makes metres toward the motor of their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableColumns {
    /// Index of the near tension, N, among the inputs.
    pub tension: usize,
    /// Index of the motor's position.
    pub motor: usize,
    /// Index of the anchor's displacement.
    pub anchor: usize,
    /// Metres toward the motor per unit of the motor's column; negative where it counts the other way.
    pub motor_scale: f64,
    /// The same for the anchor.
    pub anchor_scale: f64,
}

impl CableColumns {
    /// The sample in a row of inputs.
    #[inline]
    #[must_use]
    pub fn sample(&self, inputs: &[f64]) -> CableSample {
        let of = |i: usize| inputs.get(i).copied().unwrap_or(f64::NAN);
        CableSample {
            motor: self.motor_scale * of(self.motor),
            anchor: self.anchor_scale * of(self.anchor),
            tension_in: of(self.tension),
        }
    }
}

/// A cable that is observed at both ends: physics in place of the clamp cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedCable {
    /// What the observer believes of the cable.
    pub model: CableModel,
    /// Where its signals stand in a row.
    pub columns: CableColumns,
}

impl ObservedCable {
    /// Checks model and columns for a row of `inputs`.
    pub(super) fn validate(&self, inputs: usize) -> Result<(), Error> {
        let CableColumns { tension, motor, anchor, motor_scale, anchor_scale } = self.columns;
        let last = tension.max(motor).max(anchor);
        require("law.cable.columns", &format!("input below {inputs}"), last < inputs, last)?;
        for scale in [motor_scale, anchor_scale] {
            let sane = (1e-12..1e12).contains(&scale.abs());
            require("law.cable.columns", "a scale that is not 0", sane, scale)?;
        }
        self.model.law()?;
        Ok(())
    }
}

/// An observer at work inside a memory.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    observer: CableObserver,
    columns: CableColumns,
    /// `exp` of the whole friction angle: how far the far end can be from the near one.
    loss: f64,
    /// Measured minus believed near tension after the last sample, N.
    pub(super) innovation: f64,
}

impl Watch {
    /// `None` where the model is none, which validation has refused before.
    pub(super) fn new(cable: &ObservedCable) -> Option<Self> {
        let law = cable.model.law().ok()?;
        Some(Self {
            observer: CableObserver::new(&cable.model).ok()?,
            columns: cable.columns,
            loss: libm::exp(law.friction_angle()),
            innovation: 0.0,
        })
    }

    /// Takes a row, `dt_s` after the one before; the first of a sequence starts anew.
    #[inline]
    pub(super) fn step(&mut self, started: bool, dt_s: f64, inputs: &[f64]) -> CellOutput {
        if !started {
            self.observer.reset();
        }
        let estimate = self.observer.step(dt_s, &self.columns.sample(inputs));
        self.innovation = estimate.innovation;
        let state = estimate.far;
        // Before the cable has slid as a whole, friction may act either way.
        let (low, high) =
            if estimate.known { (state, state) } else { (state / self.loss, state * self.loss) };
        CellOutput { state, low: low.min(high), high: high.max(low), known: estimate.known }
    }
}
