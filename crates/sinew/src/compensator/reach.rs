//! Where a command can be at a sample.

use super::settings::Limits;

/// The commands that can be reached from the near side at the sample before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Where the search begins: the near side at the sample before, or the nearest that is permitted.
    pub(super) start: f64,
}

/// Part of the largest change that the predictor accepts, which keeps rounding out of its comparison.
const OF_JUMP: f64 = 0.999;

impl Reach {
    /// All that is permitted, from `reference`.
    pub(super) fn everywhere(limits: &Limits, reference: f64) -> Self {
        let Limits { min: low, max: high, .. } = *limits;
        Self { low, high, start: reference.max(low).min(high) }
    }

    /// What can be reached from `reference` in `dt_s` seconds where the predictor accepts changes up to
    /// `jump`. From outside the limits it leads back toward them.
    pub(super) fn from(limits: &Limits, reference: f64, dt_s: f64, jump: f64) -> Self {
        let step = (OF_JUMP * jump).min(limits.rate * dt_s);
        let (mut below, mut above) = (reference - step, reference + step);
        // A reference so large that a change is lost in rounding.
        if reference - below > jump || above - reference > jump {
            (below, above) = (reference, reference);
        }
        let low = below.max(limits.min).min(above);
        let high = above.min(limits.max).max(below);
        Self { low, high: high.max(low), start: reference.max(low).min(high) }
    }

    /// Nothing but `reference`.
    pub(super) fn only(reference: f64) -> Self {
        Self { low: reference, high: reference, start: reference }
    }

    /// Whether a command stands at an end that is no limit.
    pub(super) fn is_rate_limited(&self, limits: &Limits, value: f64) -> bool {
        (value >= self.high && self.high < limits.max) || (value <= self.low && self.low > limits.min)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "the bounds are exact")]

    use super::*;

    const LIMITS: Limits = Limits { near: 0, min: 0.0, max: 100.0, rate: 50.0, tolerance: 0.0 };

    #[test]
    fn a_reach_is_what_rate_jump_and_limits_leave() {
        let reach = |reference, dt_s, jump| {
            let Reach { low, high, start } = Reach::from(&LIMITS, reference, dt_s, jump);
            [low, high, start]
        };
        assert_eq!(reach(40.0, 0.1, 1e9), [35.0, 45.0, 40.0]);
        assert_eq!(reach(2.0, 0.1, 1e9), [0.0, 7.0, 2.0]);
        assert_eq!(reach(99.0, 0.1, 1e9), [94.0, 100.0, 99.0]);
        // By the largest change that the predictor accepts.
        assert_eq!(reach(40.0, 10.0, 1.0), [40.0 - 0.999, 40.0 + 0.999, 40.0]);
        // Back from outside, as fast as it may.
        assert_eq!(reach(-20.0, 0.1, 1e9), [-15.0, -15.0, -15.0]);
        assert_eq!(reach(-2.0, 0.1, 1e9), [0.0, 3.0, 0.0]);
        assert_eq!(reach(120.0, 0.1, 1e9), [115.0, 115.0, 115.0]);
        // A change below the resolution of the reference.
        assert_eq!(reach(50.0, 10.0, 1e-16), [50.0, 50.0, 50.0]);
    }

    #[test]
    fn an_end_that_is_no_limit_is_one_of_the_rate() {
        let reach = Reach::from(&LIMITS, 98.0, 0.1, 1e9);
        assert!(!reach.is_rate_limited(&LIMITS, 100.0) && reach.is_rate_limited(&LIMITS, 93.0));
        assert!(!reach.is_rate_limited(&LIMITS, 96.0));
        assert!(!Reach::everywhere(&LIMITS, 5.0).is_rate_limited(&LIMITS, 0.0));
    }
}
