//! Where the motor of a cable has to go: the stretch of steady sliding, corrected by what is left.

use crate::Error;
use crate::predictor::{CablePlace, ObservedCable};
use crate::transmission::Sliding;
use crate::transmission::cable::CableLaw;

/// Stretch of a cable for a desired far tension along a sequence of commands.
///
/// ```text
/// e*_s(T) = sum_j c_j T_j    of the cable that slides steadily in direction s with T at the anchor
/// m = dx_a + e*_s(T_k) - e*_s(T_(k-1))                   the motor's motion that follows both
/// s <- -s,  e_c <- 0   where the direction to come is known and is -s; where it is not, once m has added up to
///                      more than r against s
/// e_c' = C (T - T^) / t_c,   |e_c| <= |e*_+ - e*_-| / 2      while the motor was where it was commanded
/// e = e*_s(T) + e_c
/// ```
///
/// | symbol   | meaning                                                              | unit |
/// |----------|----------------------------------------------------------------------|------|
/// | T, dx_a  | desired tension; displacement of the anchor since the command before   | N, m |
/// | s        | direction of sliding, + toward the motor                                | 1    |
/// | r        | `REVERSAL`, above the resolution of encoders                            | m    |
/// | T^       | what the model says of the far tension, one command later               | N    |
/// | C, t_c   | compliance of the whole cable; `SETTLING`                               | m/N, s |
///
/// One sample's far tension hardly depends on the motor's motion in that sample: it spreads along the sheath.
/// The stretch decides the far tension once it has spread, and its difference in both directions is the
/// travel of the dead band. What is left is integrated where every command is observed before the next one:
/// slow motions have more friction than the speed at which dead bands are crossed, and models have memories
/// of their own.
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
    /// `C`, m/N.
    compliance: f64,
    direction: f64,
    /// The direction in which the cable will slide, where that is known.
    coming: Option<Sliding>,
    /// Motion against the direction so far, m.
    against: f64,
    /// Low-passed speed of the anchor, m/s.
    velocity: f64,
    /// `e_c`, m.
    correction: f64,
    /// Of the command before.
    last: Option<Reference>,
    initial: f64,
}

/// What a command of a cable's motor is for.
#[derive(Debug, Clone, Copy)]
pub(super) struct CableGoal {
    /// Desired far end.
    pub(super) far: f64,
    /// Displacement of the anchor, m, at a time, s.
    pub(super) anchor: f64,
    pub(super) time_s: f64,
    /// From the sample that was observed last, s.
    pub(super) ahead_s: f64,
    /// Error of the far end that the command before has left, and where that command has put the motor, m.
    pub(super) left: f64,
    pub(super) commanded: f64,
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

/// `t_c`, s: several times what the far end needs to answer.
const SETTLING: f64 = 0.1;

/// How far the exact command of a cable's motor may lie from the one by its stretch, as a fraction of half
/// its dead band: without it, the motor would move at its limits to and fro to correct in one sample what
/// takes many to arrive. A motor this near to its command is where it was commanded.
const EXACT: f64 = 0.05;

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
        let law = cable.model.law()?;
        Ok(Self {
            compliance: law.compliance().iter().sum(),
            law,
            far_gain: cable.model.far_gain,
            direction: initial,
            coming: None,
            against: 0.0,
            velocity: 0.0,
            correction: 0.0,
            last: None,
            initial,
        })
    }

    pub(super) fn reset(&mut self) {
        (self.direction, self.against, self.velocity) = (self.initial, 0.0, 0.0);
        self.correction = 0.0;
        (self.coming, self.last) = (None, None);
    }

    /// In which direction the cable will slide, or that its motion shows it.
    pub(super) fn expect(&mut self, coming: Option<Sliding>) {
        self.coming = coming;
    }

    /// The direction by which it goes.
    pub(super) fn sliding(&self) -> Option<Sliding> {
        Sliding::from_velocity(self.direction)
    }

    /// Lowest and highest position of the motor, m, from where the cable is.
    pub(super) fn motor(&mut self, goal: &CableGoal, place: &CablePlace) -> [f64; 2] {
        let CableGoal { anchor, time_s, .. } = *goal;
        let tension = (goal.far / self.far_gain).clamp(-1e6, 1e6);
        let now = Reference { time_s, anchor, tension };
        let before = self.last.replace(now).unwrap_or(now);
        let (moved, dt_s) = (anchor - before.anchor, time_s - before.time_s);
        let elapsed = dt_s > 0.0 && dt_s.is_finite();
        if elapsed {
            self.velocity += (moved / dt_s - self.velocity) * dt_s / (dt_s + SPEED_TIME);
        }
        let drag = place.drag_factor;
        let present = self.steady(tension, self.direction, drag);
        let motion = self.direction * (moved + present - self.steady(before.tension, self.direction, drag));
        self.against = (self.against - motion).max(0.0);
        let turns = match self.coming {
            Some(coming) => coming.sign() * self.direction < 0.0,
            None => self.against > REVERSAL,
        };
        if turns {
            (self.direction, self.against) = (-self.direction, 0.0);
            self.correction = 0.0;
        }
        let stretch = self.steady(tension, self.direction, drag);
        let half = 0.5 * (stretch - self.steady(tension, -self.direction, drag)).abs();
        let about = EXACT * half;
        // A command further ahead is not yet what the model has seen.
        let observed = elapsed && (dt_s - goal.ahead_s).abs() <= 1e-6 * dt_s;
        if observed && (goal.commanded - place.motor).abs() <= about {
            self.correction += dt_s / SETTLING * (self.compliance * (goal.left / self.far_gain));
        }
        self.correction = self.correction.max(-half).min(half);
        // With the stretch that it has.
        let held = place.motor + (anchor - place.anchor);
        let motor = held + (stretch + self.correction) - place.stretch;
        let [low, high] = [motor - about, motor + about];
        // In a slow motion the motor does not turn back for what is still on its way.
        let slow = motion.abs() * SETTLING <= about * dt_s;
        match self.direction > 0.0 {
            _ if !(observed && slow) => [low, high],
            true => [low.max(held.min(high)), high],
            false => [low, high.min(held.max(low))],
        }
    }

    fn steady(&self, tension: f64, direction: f64, drag: f64) -> f64 {
        let with = direction * self.velocity > 0.0;
        let velocity = if with { self.velocity } else { direction * VANISHING_SPEED };
        // Never refused: all three are finite.
        let slip = velocity.abs().max(SLIP);
        self.law.sliding(tension, velocity, slip, drag).map_or(0.0, |sliding| sliding.stretch)
    }
}
