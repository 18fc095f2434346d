//! Slow effects on a cable between two steps: heat and breakage; creep is part of the cable.

use super::effects::Effects;
use crate::transmission::cable::EndTensions;

/// Time and tension at which a cable broke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Broken {
    /// Time since the start, s.
    pub time_s: f64,
    /// Tension at the end where it was largest, N.
    pub tension: f64,
}

/// True state of the plant's cable after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableReading {
    /// At the drive's outlet, N.
    pub tension_in: f64,
    /// At the anchor, N.
    pub tension_out: f64,
    /// Total stretch from zero tension, without creep, m; negative by the excess length of a slack cable.
    pub stretch: f64,
    /// Energy dissipated by friction in this step, J.
    pub dissipated: f64,
    /// Temperature of the sheath above its surroundings, K.
    pub warming: f64,
    /// Set from the step in which the cable broke.
    pub broken: Option<Broken>,
}

/// Slow states of one cable.
#[derive(Debug, Clone)]
pub(super) struct Wear {
    effects: Effects,
    time_s: f64,
    warming: f64,
    pub(super) broken: Option<Broken>,
}

impl Wear {
    pub(super) fn new(effects: &Effects) -> Self {
        Self { effects: effects.clone(), time_s: 0.0, warming: 0.0, broken: None }
    }

    /// Updates heat and breakage from the end tensions; returns the true state.
    pub(super) fn update(&mut self, interval: f64, ends: EndTensions, stretch: f64) -> CableReading {
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
            // Explicit step, clamped for a time constant R C shorter than the step.
            self.warming = (self.warming + flow / heat.capacity).max(0.0);
        }
        let unless_broken = |value: f64| if self.broken.is_some() { 0.0 } else { value };
        CableReading {
            tension_in: unless_broken(ends.tension_in),
            tension_out: unless_broken(ends.tension_out),
            stretch,
            dissipated: unless_broken(ends.dissipated),
            warming: self.warming,
            broken: self.broken,
        }
    }

    /// Breaks the cable now, unless it is broken.
    pub(super) fn snap(&mut self, ends: EndTensions) {
        let tension = ends.tension_in.max(ends.tension_out);
        self.broken = self.broken.or(Some(Broken { time_s: self.time_s, tension }));
    }

    /// Factor on the drag; `None` without the effect of heat.
    pub(super) fn drag_factor(&self) -> Option<f64> {
        self.effects.heat.as_ref().map(|heat| libm::exp(-heat.softening * self.warming))
    }
}
