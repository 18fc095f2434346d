//! How friction depends on the speed of sliding: the one place where a law of it is written down.

use crate::error::{Error, non_negative, positive, within};
use serde::{Deserialize, Serialize};

/// Form of the fall of friction with speed: one arm of [`factor`](Self::factor) for each.
///
/// Plant, observer, identification, machine files and model files take the forms from here. Every form gives
/// `1 + beta` at rest, falls with speed, and ends at 1: with that, limits and energy balance hold for all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WeakeningForm {
    /// `1 + beta/(1 + (z/v_s)^2)`: falls off slowly.
    #[default]
    Rational,
    /// `1 + beta exp(-(z/v_s)^2 ln 2)`: Stribeck's, with half of the rise left at `v_s` as well.
    Gaussian,
}

impl WeakeningForm {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Rational, Self::Gaussian];

    /// As files name it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rational => "rational",
            Self::Gaussian => "gaussian",
        }
    }

    /// The factor on the friction coefficient for a rise and the ratio of a speed to the law's.
    #[inline(always)]
    #[must_use]
    pub fn factor(self, rise: f64, ratio: f64) -> f64 {
        match self {
            Self::Rational => 1.0 + rise / (1.0 + ratio * ratio),
            Self::Gaussian => 1.0 + rise * libm::exp(-core::f64::consts::LN_2 * ratio * ratio),
        }
    }
}

/// Velocity weakening of friction (Stribeck effect), with a lag that keeps the problem well posed.
///
/// ```text
/// mu(z) = mu f(z/v_s),  f(0) = 1 + beta,  f(1) = 1 + beta/2,    dz = dt/(tau + dt) (|v| - z)    at every node
/// ```
///
/// | symbol | field   | unit | domain | meaning                                           |
/// |--------|---------|------|--------|---------------------------------------------------|
/// | f      | `form`  | 1    |        | its form                                          |
/// | beta   | `rise`  | 1    | >= 0   | breakaway friction is `1 + beta` times sliding friction |
/// | v_s    | `speed` | m/s  | > 0    | speed at which half of the rise remains            |
/// | tau    | `lag`   | s    | >= 0.005 | time constant of the speed estimate of a node    |
///
/// # Assumes
/// Without the lag the law is ill posed along a cable: the smaller the step, the larger the jitter.
///
/// # Source
/// `stribeck1902`; the rational form and the lag are ours. The tables of `yuan2023`, at 0.02 m/s and above,
/// show no such rise and do not identify its size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weakening {
    /// `f`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub form: WeakeningForm,
    /// `beta`, 1.
    pub rise: f64,
    /// `v_s`, m/s.
    #[serde(rename = "speed_m_per_s")]
    pub speed: f64,
    /// `tau`, s.
    #[serde(rename = "lag_s")]
    pub lag: f64,
}

/// Model files from before there were forms have none.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes it so")]
fn is_default(form: &WeakeningForm) -> bool {
    *form == WeakeningForm::default()
}

impl Weakening {
    /// Of the rational form.
    #[must_use]
    pub const fn rational(rise: f64, speed: f64, lag: f64) -> Self {
        Self { form: WeakeningForm::Rational, rise, speed, lag }
    }

    /// The factor on the friction coefficient at a lagged speed `z >= 0`, m/s.
    #[inline]
    #[must_use]
    pub fn factor(&self, speed: f64) -> f64 {
        self.form.factor(self.rise, speed / self.speed)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        non_negative("weakening.rise", self.rise)?;
        positive("weakening.speed", self.speed)?;
        let lag = self.lag;
        within("weakening.lag", "a finite number >= 0.005 s", lag, lag.is_finite() && lag >= 0.005)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    #[test]
    fn friction_is_highest_at_rest_and_half_of_the_rise_remains_at_the_given_speed() {
        for form in WeakeningForm::ALL {
            let weakening = Weakening { form, ..Weakening::rational(0.6, 4e-3, 0.02) };
            for (speed, factor) in [(0.0, 1.6), (4e-3, 1.3), (40.0, 1.0)] {
                assert!((weakening.factor(speed) - factor).abs() < 1e-6, "{form:?} {speed}");
            }
        }
        assert!((Weakening::rational(0.6, 4e-3, 0.02).factor(8e-3) - 1.12).abs() < 1e-12);
    }

    #[test]
    fn every_form_falls_with_speed_and_stays_between_sliding_and_breakaway_friction() {
        for form in WeakeningForm::ALL {
            let factors: Vec<f64> = (0..400).map(|k| form.factor(0.4, 0.02 * f64::from(k))).collect();
            assert!(factors.windows(2).all(|pair| pair[1] <= pair[0]), "{form:?}");
            assert!(factors.iter().all(|factor| (1.0..=1.4).contains(factor)), "{form:?}");
        }
    }
}
