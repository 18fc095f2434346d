//! Grease that friction warms.

use crate::Error;
use crate::error::within;
use serde::{Deserialize, Serialize};

/// Friction warms the grease of a sheath, which lowers its drag.
///
/// ```text
/// dw/dt = s P - w/tau,    P = T_in v_in - T_out v_out,    drag = d/(1 + w),    0 <= w <= 4
/// ```
///
/// | symbol | argument       | unit | domain    | meaning                                                  |
/// |--------|----------------|------|-----------|----------------------------------------------------------|
/// | s      | `rate`         | 1/J  | [0, 1]    | softening of the grease per heat, `k/C`                  |
/// | tau    | `time`         | s    | [1, 1e6]  | time in which the sheath cools, `R C`                    |
/// | P dt   | `work`         | J    | finite    | work of both ends on the cable in the interval           |
/// | dt     | `interval`     | s    | any       | none where it is not positive                            |
/// | w      | `warmth`       | 1    | [0, 4]    | softening of the grease, 0 as cold as at the first sample |
///
/// `w` is integrated implicitly, so that intervals of any length cool it.
///
/// # Assumes
/// One temperature along the cable and a fluidity of the grease that grows in proportion to it. What the
/// cable stores elastically counts as heat until it is given back: a few per cent of a minute's friction.
///
/// # Example
/// ```
/// use sinew::transmission::Warming;
/// let warming = Warming { rate: 6e-4, time: 40.0 };
/// // 5 W of friction for five minutes.
/// let warmth = (0..30_000).fold(0.0, |warmth, _| warming.step(warmth, 0.05, 0.01));
/// assert!((warmth - 6e-4 * 5.0 * 40.0).abs() < 1e-3);
/// assert!((Warming::drag_factor(warmth) - 1.0 / 1.12).abs() < 1e-3);
/// ```
///
/// # Source
/// Our own: one heat capacity behind one resistance. Greases lose half of their viscosity in 15 to 20 K.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Warming {
    /// `s`, 1/J.
    #[serde(rename = "rate_per_j")]
    pub rate: f64,
    /// `tau`, s.
    #[serde(rename = "time_s")]
    pub time: f64,
}

impl Warming {
    /// Refuses numbers outside of the table's domains.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number.
    pub fn check(&self) -> Result<(), Error> {
        within("warming rate", "a number in [0, 1] 1/J", self.rate, (0.0..=1.0).contains(&self.rate))?;
        within("warming time", "a number in [1, 1e6] s", self.time, (1.0..=1e6).contains(&self.time))?;
        Ok(())
    }

    /// `w` after an interval.
    #[must_use]
    pub fn step(&self, warmth: f64, work: f64, interval: f64) -> f64 {
        let warmed = (warmth + self.rate * work) / (1.0 + interval.max(0.0) / self.time);
        warmed.clamp(0.0, 4.0)
    }

    /// Drag as a multiple of that of cold grease.
    #[must_use]
    pub fn drag_factor(warmth: f64) -> f64 {
        1.0 / (1.0 + warmth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn warmth_approaches_the_power_and_cools_in_its_time() {
        let warming = Warming { rate: 1e-3, time: 30.0 };
        let run = |start: f64, power: f64, seconds: u32| {
            (0..100 * seconds).fold(start, |warmth, _| warming.step(warmth, 0.01 * power, 0.01))
        };
        for power in [1.0, 5.0, 12.0] {
            let steady = 1e-3 * power * 30.0;
            assert!((run(0.0, power, 600) / steady - 1.0).abs() < 1e-6);
            assert!((run(0.0, power, 30) / steady - (1.0 - libm::exp(-1.0))).abs() < 1e-3);
            assert!((run(steady, 0.0, 30) / steady - libm::exp(-1.0)).abs() < 1e-3);
        }
        // A pause in one step cools at most as much as its time does.
        let paused = warming.step(0.3, 0.0, 300.0);
        assert!((0.0..0.03).contains(&paused) && paused > 0.3 * libm::exp(-10.0));
    }

    #[test]
    fn whatever_the_work_drag_stays_between_a_fifth_and_the_whole() {
        let warming = Warming { rate: 1.0, time: 1.0 };
        for (work, interval) in
            [(1e9, 0.01), (-1e9, 0.01), (3.0, -1.0), (3.0, f64::NAN), (0.0, f64::INFINITY)]
        {
            let factor = Warming::drag_factor(warming.step(0.5, work, interval));
            assert!((0.2..=1.0).contains(&factor), "{work} J in {interval} s: {factor}");
        }
    }

    #[test]
    fn numbers_outside_of_their_domains_are_refused_by_name() {
        let refused = |rate: f64, time: f64| Warming { rate, time }.check().unwrap_err().to_string();
        for rate in [-1e-9, 1.1, f64::NAN, f64::INFINITY] {
            assert!(refused(rate, 40.0).contains("warming rate"));
        }
        for time in [0.5, 2e6, f64::NAN] {
            assert!(refused(1e-3, time).contains("warming time"));
        }
        assert!(Warming { rate: 0.0, time: 1.0 }.check().is_ok());
    }
}
