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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predictor::CableModel;

    const INTERVAL: f64 = 2e-3;

    fn controller() -> (StretchController, CableLaw) {
        let law = CableModel::bench().law().unwrap();
        (StretchController::new(law.clone()), law)
    }

    fn reference(tension_out: f64, velocity: f64) -> FarEndReference {
        FarEndReference { tension_out, velocity, previewed_velocity: velocity }
    }

    #[test]
    fn at_the_desired_stretch_the_winch_follows_the_anchor() {
        for velocity in [0.05, -0.05] {
            let (mut controller, law) = controller();
            // Drag counts at the reference's speed, as often as the estimate says.
            let stretch = law.steady(80.0, velocity, 1.5).unwrap().stretch;
            assert!((stretch - law.steady(80.0, 0.01 * velocity, 1.5).unwrap().stretch).abs() > 1e-5);
            for _ in 0..3 {
                let speed =
                    controller.winch_speed(INTERVAL, &reference(80.0, velocity), stretch, 1.5).unwrap();
                assert!((speed - velocity).abs() < 1e-15, "{speed}");
            }
        }
    }

    #[test]
    fn an_error_of_the_stretch_decays_with_the_time_constant_and_brakes_at_the_winchs_deceleration() {
        let (mut controller, law) = controller();
        let desired = law.steady(80.0, 0.05, 1.0).unwrap().stretch;
        // Both laws give the same speed at 2 a t_v^2 = 3.2 mm.
        for (error, expected) in [
            (1e-3, 1e-3 / 0.02),
            (3.1e-3, 3.1e-3 / 0.02),
            (3.3e-3, libm::sqrt(2.0 * 4.0 * 3.3e-3)),
            (1e-2, libm::sqrt(2.0 * 4.0 * 1e-2)),
        ] {
            for sign in [1.0, -1.0] {
                let stretch = desired - sign * error;
                let speed = controller.winch_speed(INTERVAL, &reference(80.0, 0.05), stretch, 1.0).unwrap();
                assert!((speed - 0.05 - sign * expected).abs() < 1e-16, "{error} {speed}");
            }
        }
    }

    #[test]
    fn a_growing_tension_is_led_by_the_rate_of_its_stretch_except_from_one_direction_to_the_other() {
        for s in [1.0, -1.0] {
            let (mut controller, law) = controller();
            let stretch = |tension, velocity| law.steady(tension, velocity, 1.0).unwrap().stretch;
            let (first, second) = (stretch(80.0, 0.05 * s), stretch(81.0, 0.06 * s));
            controller.winch_speed(INTERVAL, &reference(80.0, 0.05 * s), first, 1.0).unwrap();
            let speed = controller.winch_speed(INTERVAL, &reference(81.0, 0.06 * s), second, 1.0).unwrap();
            let rate = (second - first) / INTERVAL;
            assert!(rate.abs() > 0.01 && (speed - 0.06 * s - rate).abs() < 1e-15, "{speed} {rate}");
            let back = stretch(81.0, -0.05 * s);
            assert!((back - second).abs() > 1e-3);
            let speed = controller.winch_speed(INTERVAL, &reference(81.0, -0.05 * s), back, 1.0).unwrap();
            assert!((speed + 0.05 * s).abs() < 1e-15, "{speed}");
        }
    }

    #[test]
    fn before_a_reversal_the_stretch_is_that_of_the_coming_direction_without_drag() {
        for s in [1.0, -1.0] {
            // Still sliding the other way, or at rest.
            for velocity in [-0.05 * s, 0.0, -0.0] {
                let (mut controller, law) = controller();
                let stretch = law.steady(80.0, s * 1e-9, 1.0).unwrap().stretch;
                let reference = FarEndReference { tension_out: 80.0, velocity, previewed_velocity: 0.05 * s };
                let speed = controller.winch_speed(INTERVAL, &reference, stretch, 1.0).unwrap();
                assert!((speed - velocity).abs() < 1e-15, "{speed} {velocity}");
            }
        }
    }
}
