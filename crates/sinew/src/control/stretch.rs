//! The winch's speed that gives a cable the stretch of the desired far tension.

use crate::Error;
use crate::transmission::Sliding;
use crate::transmission::cable::CableLaw;

/// Reference of a cable's far end for the next control cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarEndReference {
    /// Desired tension at the anchor, N.
    pub tension_out: f64,
    /// Reference speed of the anchor, m/s, + toward the motor; its sign is the direction of sliding.
    pub velocity: f64,
    /// The same at the end of the [`PREVIEW_HORIZON`].
    pub previewed_velocity: f64,
}

/// `t_p`, s: preview of references, about the time in which a winch reverses.
pub const PREVIEW_HORIZON: f64 = 0.12;

/// The winch gives the cable the stretch of steady sliding at the reference's speed and desired far tension.
///
/// ```text
/// e* = sum_j c_j T*_j       of the steadily sliding cable: T*_(M-1) = T_out* - T_0, speed v_r
/// v = v_r + de*/dt + X,   X = clip((e* - e^)/t_v, +- sqrt(2 a |e* - e^|))
/// ```
///
/// | symbol      | meaning                                                       | unit   |
/// |-------------|---------------------------------------------------------------|--------|
/// | T_out*, v_r | desired far tension, reference speed of the anchor              | N, m/s |
/// | e^          | estimated stretch                                              | m      |
/// | t_v         | 0.02, above that of the drive's velocity loop                   | s      |
/// | a           | 4, below the drive's 5                                         | m/s^2  |
///
/// While the whole cable slides, its stretch determines its far tension, and at a reversal the difference of
/// the two stretches is the travel of the slip front: one law for both. A tension loop at the drive has
/// neither property, because near tension carries no information on the far end while the near end sticks.
///
/// # Departs
/// `yuan2023` commands the tension of the drive (8); here it is the speed of its winch.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub struct StretchController {
    law: CableLaw,
    /// Direction of sliding and desired stretch, m, of the last step.
    last: Option<(f64, f64)>,
}

/// Speed, m/s, with the direction of sliding but without drag; well above subnormal numbers.
pub(super) const VANISHING_SPEED: f64 = 1e-9;

/// `t_v`, s.
const STRETCH_TIME_CONSTANT: f64 = 0.02;
/// `a`, m/s^2.
const WINCH_DECELERATION: f64 = 4.0;

impl StretchController {
    /// A controller by an identified law.
    #[must_use]
    pub fn new(law: CableLaw) -> Self {
        Self { law, last: None }
    }

    /// Speed of the winch, m/s, + toward the motor, for the `interval` seconds to come, from the estimated
    /// stretch, m, and the drag as a multiple of the law's.
    ///
    /// # Errors
    /// As [`CableLaw::steady`].
    pub fn winch_speed(
        &mut self,
        interval: f64,
        reference: &FarEndReference,
        stretch: f64,
        drag_factor: f64,
    ) -> Result<f64, Error> {
        let s = direction(reference.previewed_velocity).sign();
        // Drag acts where the cable already slides in the previewed direction, not during a reversal.
        let velocity = reference.velocity;
        let sliding = if s * velocity > 0.0 { velocity } else { s * VANISHING_SPEED };
        let desired = self.law.steady(reference.tension_out, sliding, drag_factor)?.stretch;
        let rate = match self.last.replace((s, desired)) {
            Some((before, last)) if s * before > 0.0 => (desired - last) / interval,
            _ => 0.0,
        };
        let error = desired - stretch;
        let most = libm::sqrt(2.0 * WINCH_DECELERATION * error.abs());
        Ok(velocity + rate + (error / STRETCH_TIME_CONSTANT).clamp(-most, most))
    }
}

/// Direction in which a cable slides at a reference speed; rest counts as toward the motor.
pub(super) fn direction(velocity: f64) -> Sliding {
    if velocity >= 0.0 { Sliding::TowardMotor } else { Sliding::AwayFromMotor }
}
