//! What happens to a cable between two steps: it warms, creeps, breaks.

use super::effects::Effects;
use crate::transmission::cable::EndTensions;
use alloc::vec;
use alloc::vec::Vec;

/// When and at which tension a cable broke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Broken {
    /// Time since the start, s.
    pub time_s: f64,
    /// Tension at the end where it was largest, N.
    pub tension: f64,
}

/// The plant's cable after a step, true values: sensors are elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableReading {
    /// At the drive's outlet, N.
    pub tension_in: f64,
    /// At the anchor, N.
    pub tension_out: f64,
    /// Total stretch from zero tension, without creep, m; negative by how much a slack cable is too long.
    pub stretch: f64,
    /// Work that friction took in this step, J.
    pub dissipated: f64,
    /// Sheath above its surroundings, K.
    pub warming: f64,
    /// Set from the step on in which the cable broke.
    pub broken: Option<Broken>,
}

/// The slow states of one cable.
#[derive(Debug, Clone)]
pub(super) struct Wear {
    effects: Effects,
    time_s: f64,
    warming: f64,
    /// `x_j`, m, and how much they grew in the last step: `[cells]`, or empty without creep.
    crept: Vec<f64>,
    growth: Vec<f64>,
    pub(super) broken: Option<Broken>,
}

impl Wear {
    pub(super) fn new(effects: &Effects, cells: usize) -> Self {
        let cells = if effects.creep.is_some() { cells } else { 0 };
        Self {
            effects: effects.clone(),
            time_s: 0.0,
            warming: 0.0,
            crept: vec![0.0; cells],
            growth: vec![0.0; cells],
            broken: None,
        }
    }

    /// Takes what the ends felt; returns the reading.
    pub(super) fn feel(&mut self, interval: f64, ends: EndTensions, stretch: f64) -> CableReading {
        self.time_s += interval;
        let tension = ends.tension_in.max(ends.tension_out);
        if let Some(breakage) = &self.effects.breakage
            && self.broken.is_none()
            && tension > breakage.tension
        {
            self.broken = Some(Broken { time_s: self.time_s, tension });
        }
        if let Some(heat) = &self.effects.heat {
            let flow = ends.dissipated.max(0.0) - interval * self.warming / heat.resistance.max(1e-9);
            // A step is far shorter than R C unless the numbers are odd: never below the surroundings.
            self.warming = (self.warming + flow / heat.capacity).max(0.0);
        }
        let whole = |tension: f64| if self.broken.is_some() { 0.0 } else { tension };
        CableReading {
            tension_in: whole(ends.tension_in),
            tension_out: whole(ends.tension_out),
            stretch,
            dissipated: whole(ends.dissipated),
            warming: self.warming,
            broken: self.broken,
        }
    }

    /// Breaks the cable here and now, unless it is broken.
    pub(super) fn snap(&mut self, ends: EndTensions) {
        let tension = ends.tension_in.max(ends.tension_out);
        self.broken = self.broken.or(Some(Broken { time_s: self.time_s, tension }));
    }

    /// Factor on the drag, if it changes at all.
    pub(super) fn drag_factor(&self) -> Option<f64> {
        self.effects.heat.as_ref().map(|heat| libm::exp(-heat.softening * self.warming))
    }

    /// Growth of every cell, m, if there is creep; `tensions` and `compliance` are those of the cells.
    pub(super) fn creep(
        &mut self,
        interval: f64,
        tensions: impl Iterator<Item = f64>,
        compliance: impl Iterator<Item = f64>,
    ) -> Option<&[f64]> {
        let creep = self.effects.creep.as_ref()?;
        let rate = interval / (creep.time + interval);
        let cells = self.crept.iter_mut().zip(&mut self.growth);
        for ((crept, growth), (tension, compliance)) in cells.zip(tensions.zip(compliance)) {
            *growth = rate * (creep.share * compliance * tension - *crept);
            *crept += *growth;
        }
        Some(&self.growth)
    }
}
