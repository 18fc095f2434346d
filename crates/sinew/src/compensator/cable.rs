//! Where the motor of a cable has to go: the stretch of steady sliding, corrected by what is left.

use crate::Error;
use crate::predictor::{CablePlace, ObservedCable};
use crate::transmission::Sliding;
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// Stretch of a cable for a desired far tension along a sequence of commands.
///
/// ```text
/// e*(T) = sum_j c_j T_j     of the cable that slides steadily with T at the anchor, node i in direction s_i
/// m_i = dx_a + sum_(j>=i) c_j dT_j                         the motion of node i that follows both
/// s_1 .. s_i <- -s_i,  e_c <- 0     once m_i has added up to more than r against s_i: of the node at the anchor
///                      at any time, or where its direction to come is known and is another; of others while
///                      e^ = e, and dx_a is in the direction to come
/// e_c' = C (T - T^) / t_c,   |e_c| <= |e*_+ - e*_-| / 2       while the motor was where it was commanded
/// e = e*(T) + e_c
/// ```
///
/// | symbol   | meaning                                                              | unit |
/// |----------|----------------------------------------------------------------------|------|
/// | T, dx_a  | desired tension; displacement of the anchor since the command before   | N, m |
/// | s_i      | direction of sliding, + toward the motor, of a node; 1 next to the motor | 1    |
/// | r        | `REVERSAL`, above the resolution of encoders                            | m    |
/// | e^, T^   | stretch and far tension of the model                                   | m, N |
/// | C, t_c   | compliance of the whole cable; `SETTLING`                               | m/N, s |
///
/// One sample's far tension hardly depends on the motor's motion in that sample: it spreads along the sheath.
/// The stretch decides the far tension once it has spread, and its difference in both directions is the
/// travel of the dead band. Where the anchor goes one way and a changing tension takes the motor the other
/// way, the two ends of the cable slide in two directions. What turns a node has to pass through all nodes
/// between it and the motor: they turn with it, and may turn back once it has arrived.
///
/// What is left is integrated where every command is observed before the next one: slow motions have more
/// friction than the speed at which dead bands are crossed, and models have memories of their own.
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
    /// `s_i`, the motion against it so far, m, and `m_i`, m.
    direction: Vec<f64>,
    against: Vec<f64>,
    motion: Vec<f64>,
    /// The direction in which the cable will slide at the anchor, where that is known.
    coming: Option<Sliding>,
    /// Whether the cable had the stretch of the command before.
    arrived: bool,
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

/// Nearer to its stretch than this fraction of half its dead band, a cable has crossed it.
const ARRIVED: f64 = 0.1;

/// Smallest speed at which the velocity weakening is evaluated, m/s: a dead band is crossed in motion, and
/// the friction of rest would lead beyond its end.
const SLIP: f64 = 0.02;

/// Speed that no anchor has, m/s.
const FASTEST: f64 = 100.0;

/// Speed with a direction but without drag, m/s.
const VANISHING_SPEED: f64 = 1e-9;

impl CableStretch {
    /// # Errors
    /// As [`CableModel::law`](crate::predictor::CableModel::law).
    pub(super) fn new(cable: &ObservedCable) -> Result<Self, Error> {
        let initial = if cable.model.start < 0.0 { -1.0 } else { 1.0 };
        let law = cable.model.law()?;
        let nodes = law.nodes().len();
        Ok(Self {
            compliance: law.compliance().iter().sum(),
            law,
            far_gain: cable.model.far_gain,
            direction: vec![initial; nodes],
            against: vec![0.0; nodes],
            motion: vec![0.0; nodes],
            coming: None,
            arrived: false,
            velocity: 0.0,
            correction: 0.0,
            last: None,
            initial,
        })
    }

    pub(super) fn reset(&mut self) {
        self.direction.fill(self.initial);
        self.against.fill(0.0);
        (self.velocity, self.correction) = (0.0, 0.0);
        (self.coming, self.arrived, self.last) = (None, false, None);
    }

    /// In which direction the cable will slide at the anchor, or that its motion shows it.
    pub(super) fn expect(&mut self, coming: Option<Sliding>) {
        self.coming = coming;
    }

    /// The direction at the anchor by which it goes.
    pub(super) fn sliding(&self) -> Option<Sliding> {
        self.direction.last().and_then(|direction| Sliding::from_velocity(*direction))
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
            let velocity = (moved / dt_s).clamp(-FASTEST, FASTEST);
            self.velocity += (velocity - self.velocity) * dt_s / (dt_s + SPEED_TIME);
        }
        let drag = place.drag_factor;
        self.turn(moved, [before.tension, tension], drag);
        let stretch = self.steady(tension, drag, |i| self.direction[i]);
        let [toward, away] = [1.0, -1.0].map(|direction| self.steady(tension, drag, |_| direction));
        let half = 0.5 * (toward - away).abs();
        let about = EXACT * half;
        // A command further ahead is not yet what the model has seen.
        let observed = elapsed && (dt_s - goal.ahead_s).abs() <= 1e-6 * dt_s;
        if observed && (goal.commanded - place.motor).abs() <= about {
            self.correction += dt_s / SETTLING * (self.compliance * (goal.left / self.far_gain));
        }
        self.correction = self.correction.max(-half).min(half);
        let ahead = stretch + self.correction - place.stretch;
        self.arrived = ahead.abs() <= ARRIVED * half;
        // With the stretch that it has.
        let held = place.motor + (anchor - place.anchor);
        let [low, high] = [held + ahead - about, held + ahead + about];
        // In a slow motion the motor does not turn back for what is still on its way.
        let near = self.motion.first().zip(self.direction.first());
        let slow = |motion: f64| motion.abs() * SETTLING <= about * dt_s;
        match near {
            Some((motion, direction)) if observed && slow(*motion) && *direction > 0.0 => {
                [low.max(held.min(high)), high]
            }
            Some((motion, _)) if observed && slow(*motion) => [low, high.min(held.max(low))],
            _ => [low, high],
        }
    }

    /// Turns what moves against its direction as the anchor moves and the desired tension changes.
    fn turn(&mut self, moved: f64, [before, now]: [f64; 2], drag: f64) {
        let mut motion = core::mem::take(&mut self.motion);
        motion.fill(moved);
        for (tension, sign) in [(now, 1.0), (before, -1.0)] {
            let add = |i: usize, beyond: f64| motion[i] += sign * beyond;
            self.law.profile(tension, drag, |i| self.slides(self.direction[i]), add);
        }
        // What moves before the turn to come says nothing of what follows it.
        let turned = self.coming.is_none_or(|coming| coming.sign() * moved >= 0.0);
        for (i, motion) in motion.iter().enumerate().rev() {
            let direction = self.direction[i];
            let at_anchor = i + 1 == self.direction.len();
            if at_anchor || (self.arrived && turned) {
                self.against[i] = (self.against[i] - direction * motion).max(0.0);
            }
            let turns = match self.coming {
                Some(coming) if at_anchor => coming.sign() * direction < 0.0,
                _ => self.against[i] > REVERSAL,
            };
            if turns {
                self.direction[..=i].fill(-direction);
                self.against[..=i].fill(0.0);
                self.correction = 0.0;
            }
        }
        self.motion = motion;
    }

    /// Stretch of steady sliding with a tension at the anchor, each node in its direction, m.
    fn steady(&self, tension: f64, drag: f64, direction: impl Fn(usize) -> f64) -> f64 {
        self.law.profile(tension, drag, |i| self.slides(direction(i)), |_, _| ()).stretch
    }

    /// Velocity of a node in a direction, m/s, and the factor on its friction that weakens.
    fn slides(&self, direction: f64) -> (f64, f64) {
        let with = direction * self.velocity > 0.0;
        let velocity = if with { self.velocity } else { direction * VANISHING_SPEED };
        (velocity, self.law.weakened(velocity.abs().max(SLIP)))
    }
}
