use super::clamp_cell::saturate;
use crate::error::{Error, non_negative};

/// Play and stop operators: the rate-independent hysteresis of backlash and of dry friction.
///
/// ```text
/// play:  p <- clamp(p, u - r, u + r)          output that follows u with backlash r
/// stop:  u - p, in [-r, r]                    deflection within the dead band
/// ```
///
/// | symbol | argument | unit      | domain | meaning                                     |
/// |--------|----------|-----------|--------|---------------------------------------------|
/// | r      | `radius` | as `u`    | >= 0   | half width of the dead band                  |
/// | u      | `input`  | any       | finite | input signal                                 |
/// | p      | `play`   | as `u`    | finite | state; start it at the first input           |
///
/// As a friction force, `k` times the stop is one Maxwell-slip element of stiffness `k` and slip force `k r`.
///
/// # Assumes
/// Rate-independent: only the extremes of the path matter, not its timing.
///
/// # Example
/// ```
/// use sinew::transmission::Play;
/// let backlash = Play::new(0.5)?;
/// let mut play = 0.0;
/// for input in [0.4, 1.0, 0.6] {
///     play = backlash.step(play, input);
/// }
/// assert_eq!(play, 0.5);                       // moved by 1.0, left by 0.6
/// assert!((backlash.stop(play, 0.6) - 0.1).abs() < 1e-15);
/// assert_eq!(Play::new(0.0)?.step(0.0, 0.6), 0.6);  // no dead band, no hysteresis
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `brokate1996`, ch. 2; `krasnoselskii1989`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "backlash")]
#[doc(alias = "prandtl_ishlinskii")]
pub struct Play {
    radius: f64,
}

impl Play {
    /// A play operator of checked radius.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the radius is negative or not finite.
    pub fn new(radius: f64) -> Result<Self, Error> {
        Ok(Self { radius: non_negative("radius", radius)? })
    }

    /// Half width of the dead band, in the unit of the input.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The play after the input has moved; an input that is not finite leaves it where it is.
    #[inline]
    #[must_use]
    pub fn step(&self, play: f64, input: f64) -> f64 {
        if input.is_finite() { saturate(play, input - self.radius, input + self.radius) } else { play }
    }

    /// The stop that belongs to a play: `input - play`, within +-radius after a [`Play::step`].
    #[inline]
    #[must_use]
    pub fn stop(&self, play: f64, input: f64) -> f64 {
        input - play
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn play_does_not_care_how_fast_or_finely_a_path_is_walked(
            path in proptest::collection::vec(-3.0..3.0_f64, 2..20), radius in 0.0..2.0_f64, parts in 2..7_u32,
        ) {
            let law = Play::new(radius).unwrap();
            let (mut coarse, mut fine) = (path[0], path[0]);
            for pair in path.windows(2) {
                coarse = law.step(coarse, pair[1]);
                for i in 1..=parts {
                    let input = pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(parts);
                    fine = law.step(fine, if i == parts { pair[1] } else { input });
                }
                prop_assert!((coarse - fine).abs() < 1e-14);
                prop_assert!(law.stop(coarse, pair[1]).abs() <= radius + 1e-14);
            }
        }
    }

    #[test]
    fn a_large_cycle_wipes_out_what_happened_before() {
        let law = Play::new(0.3).unwrap();
        let ends: Vec<f64> = [-5.0, 0.1, 4.0]
            .into_iter()
            .map(|start| [9.0, -9.0, 1.0].into_iter().fold(start, |play, input| law.step(play, input)))
            .collect();
        assert!(ends.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 1e-15));
    }

    #[test]
    fn what_is_not_finite_is_held() {
        let law = Play::new(0.3).unwrap();
        for input in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!((law.step(1.0, input) - 1.0).abs() < 1e-15);
        }
        assert!(Play::new(-0.1).is_err() && Play::new(f64::INFINITY).is_err());
    }

    #[test]
    fn the_dead_band_is_twice_the_radius_wide() {
        let law = Play::new(0.3).unwrap();
        let up = law.step(0.0, 2.0);
        assert!((law.step(up, -2.0) - up + 4.0 - 2.0 * law.radius()).abs() < 3e-16);
        assert!((law.radius() - 0.3).abs() < 1e-15);
    }
}
