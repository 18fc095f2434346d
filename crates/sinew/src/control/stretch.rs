//! The winch's speed that gives a cable the stretch of the wanted far tension.

use crate::transmission::cable::CableLaw;

/// What is wanted of the far end in the next millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarEndReference {
    /// Tension wanted at the anchor, N.
    pub tension_out: f64,
    /// Speed at which the anchor is known to be going to move, m/s, + toward the motor: its sign says which way it slides.
    pub velocity: f64,
    /// The same [`PREVIEW_HORIZON`] later.
    pub previewed_velocity: f64,
}

/// How far ahead [`FarEndReference::previewed_velocity`] looks, s: a winch that turns round takes its time.
pub const PREVIEW_HORIZON: f64 = 0.12;

/// The winch gives the cable the stretch that it has while it slides as wanted, at the wanted far tension.
///
/// ```text
/// e* = sum_j c_j T*_j                        of the steadily sliding cable: T*_(M-1) = T_out* - T_0, speed v_r
/// v = v_r + de*/dt + X,   X = clip((e* - e^)/t_v, +- sqrt(2 a |e* - e^|))
/// ```
///
/// | symbol      | meaning                                                              | unit   |
/// |-------------|----------------------------------------------------------------------|--------|
/// | T_out*, v_r | wanted far tension and known speed of the anchor                       | N, m/s |
/// | e^          | stretch as believed                                                   | m      |
/// | t_v         | 0.02: slower than the drive's velocity loop                            | s      |
/// | a           | 4: with a little left of the drive's 5, for the winch to be braked       | m/s^2  |
///
/// While all of the cable slides its stretch *is* its far tension, and at a reversal the difference of the two stretches
/// is the travel that carries the front through: one law for both. A tension loop can do neither: what it measures says
/// nothing about the far end while the near one sticks.
///
/// # Departs
/// `yuan2023` commands the tension of the drive (8); here it is the speed of its winch.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub struct StretchController {
    law: CableLaw,
    last: Option<(f64, f64)>,
}

/// A speed whose sign counts and whose drag does not, m/s; and a number that a processor handles at full speed.
pub(super) const BARELY: f64 = 1e-9;

/// `t_v`, s.
const SETTLING: f64 = 0.02;
/// `a`, m/s^2.
const BRAKING: f64 = 4.0;

impl StretchController {
    /// A follower of this law, as identified.
    #[must_use]
    pub fn new(law: CableLaw) -> Self {
        Self { law, last: None }
    }

    /// Speed of the winch, m/s, + toward the motor, for the `interval` seconds to come, with the stretch as it is
    /// believed to be, m, and the drag times that of the law.
    pub fn speed(&mut self, interval: f64, wish: &FarEndReference, stretch: f64, drag_factor: f64) -> f64 {
        let s = direction(wish.previewed_velocity);
        // Drag is that of now where the cable already slides as it is going to, and none yet where it turns.
        let sliding = if s * wish.velocity > 0.0 { wish.velocity } else { s * BARELY };
        let Ok(steady) = self.law.steady(wish.tension_out, sliding, drag_factor) else {
            return wish.velocity;
        };
        let wanted = steady.stretch;
        let feed = match self.last.replace((s, wanted)) {
            Some((before, last)) if s * before > 0.0 => (wanted - last) / interval,
            _ => 0.0,
        };
        let missing = wanted - stretch;
        let most = libm::sqrt(2.0 * BRAKING * missing.abs());
        wish.velocity + feed + (missing / SETTLING).clamp(-most, most)
    }
}

/// Which way a cable slides by the speed that is wanted of it: a rest counts as toward the motor.
pub(super) fn direction(velocity: f64) -> f64 {
    if velocity >= 0.0 { 1.0 } else { -1.0 }
}
