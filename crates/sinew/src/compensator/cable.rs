//! Where the motor of a cable has to go: the stretch of steady sliding.

use crate::Error;
use crate::predictor::ObservedCable;
use crate::transmission::cable::CableLaw;

/// Stretch of a cable for a desired far tension along a sequence of commands.
///
/// ```text
/// e*_s(T) = sum_j c_j T_j    of the cable that slides steadily in direction s with T at the anchor
/// m = dx_a + e*_s(T_k) - e*_s(T_(k-1))                   the motor's motion that follows both
/// s <- -s   once m has added up to more than r against s
/// ```
///
/// | symbol  | meaning                                                              | unit |
/// |---------|----------------------------------------------------------------------|------|
/// | T, dx_a | desired tension; displacement of the anchor since the command before   | N, m |
/// | s       | direction of sliding, + toward the motor                                | 1    |
/// | r       | `REVERSAL`, above the resolution of encoders                            | m    |
///
/// One sample's far tension hardly depends on the motor's motion in that sample: it spreads along the sheath.
/// The stretch decides the far tension once it has spread, and its difference in both directions is the
/// travel of the dead band.
///
/// # Departs
/// `yuan2023`, (8): a drive's tension. As in the control of muscles, the stretch.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(super) struct CableStretch {
    law: CableLaw,
    far_gain: f64,
    direction: f64,
    /// Motion against the direction so far, m.
    against: f64,
    /// Low-passed speed of the anchor, m/s.
    velocity: f64,
    /// Of the command before.
    last: Option<Reference>,
    initial: f64,
}

/// What a command follows.
#[derive(Debug, Clone, Copy)]
struct Reference {
    time_s: f64,
    anchor: f64,
    tension: f64,
}

/// `r`, m.
const REVERSAL: f64 = 5e-5;

/// Time constant of the anchor's speed, s.
const SPEED_TIME: f64 = 0.01;

/// Smallest speed at which the velocity weakening is evaluated, m/s: a dead band is crossed in motion, and
/// the friction of rest would lead beyond its end.
const SLIP: f64 = 0.02;

/// Speed with a direction but without drag, m/s.
const VANISHING_SPEED: f64 = 1e-9;

impl CableStretch {
    /// # Errors
    /// As [`CableModel::law`](crate::predictor::CableModel::law).
    pub(super) fn new(cable: &ObservedCable) -> Result<Self, Error> {
        let initial = if cable.model.start < 0.0 { -1.0 } else { 1.0 };
        Ok(Self {
            law: cable.model.law()?,
            far_gain: cable.model.far_gain,
            direction: initial,
            against: 0.0,
            velocity: 0.0,
            last: None,
            initial,
        })
    }

    pub(super) fn reset(&mut self) {
        (self.direction, self.against, self.velocity) = (self.initial, 0.0, 0.0);
        self.last = None;
    }

    /// The stretch, m, for a desired far end and an anchor, m, at a time, s, with the drag
    /// as a multiple of the law's; and half the difference between both directions.
    pub(super) fn desired(&mut self, far: f64, anchor: f64, time_s: f64, drag: f64) -> (f64, f64) {
        let tension = (far / self.far_gain).clamp(-1e6, 1e6);
        let now = Reference { time_s, anchor, tension };
        let before = self.last.replace(now).unwrap_or(now);
        let (moved, dt_s) = (anchor - before.anchor, time_s - before.time_s);
        if dt_s > 0.0 && dt_s.is_finite() {
            self.velocity += (moved / dt_s - self.velocity) * dt_s / (dt_s + SPEED_TIME);
        }
        let present = self.steady(tension, self.direction, drag);
        let motion = self.direction * (moved + present - self.steady(before.tension, self.direction, drag));
        self.against = (self.against - motion).max(0.0);
        if self.against > REVERSAL {
            (self.direction, self.against) = (-self.direction, 0.0);
        }
        let other = self.steady(tension, -self.direction, drag);
        let stretch = self.steady(tension, self.direction, drag);
        (stretch, 0.5 * (stretch - other).abs())
    }

    fn steady(&self, tension: f64, direction: f64, drag: f64) -> f64 {
        let with = direction * self.velocity > 0.0;
        let velocity = if with { self.velocity } else { direction * VANISHING_SPEED };
        // Never refused: all three are finite.
        let slip = velocity.abs().max(SLIP);
        self.law.sliding(tension, velocity, slip, drag).map_or(0.0, |sliding| sliding.stretch)
    }
}
