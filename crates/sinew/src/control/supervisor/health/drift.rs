/// How far a number has drifted since the beginning, from one value a window.
///
/// ```text
/// x_0, s_0    mean and standard deviation of the first n_0 values
/// s^2 <- s^2 + (min(u^2/2, 9 s^2) - s^2)/n,   u the difference of two successive values, s = s_0 at first
/// z = (x - x_0)/max(s_0, s, s_min, s_x/2)
/// S+ <- max(0, S+ + z - k),   S- <- max(0, S- - z - k)                      CUSUM
/// found       S > h  and  |d| > d_min,   d the mean over the last values
/// slope       exponentially weighted least squares of x over time, memory of n_f values
/// ```
///
/// | symbol | meaning                                              | value |
/// |--------|------------------------------------------------------|-------|
/// | n_0, n_f | values at the beginning; memory of slope and mean   | 8, 8, 4 |
/// | n      | values so far, less one                              | at most 64 |
/// | k, h   | allowance and threshold                              | [`DriftRule`] |
/// | s_x    | standard deviation that the fit of `x` states, in the mean of the first values |     |
/// | s_min, d_min | least deviation, least drift that is reported    | [`DriftRule`] |
///
/// Of eight values the deviation is known to a quarter: differences of successive values, to which a slow
/// drift adds little, make it more precise. A step counts as three deviations. Values of one motion are not
/// independent, and the mean of eight errs as well: so the allowance.
///
/// # Source
/// `page1954` (CUSUM), `vonneumann1941` (differences).
#[derive(Debug, Clone, Copy)]
pub(super) struct DriftWatch {
    rule: DriftRule,
    count: f64,
    mean: f64,
    squares: f64,
    /// `s^2`, and the value before.
    variance: f64,
    last: f64,
    /// Mean of `s_x`.
    stated: f64,
    sums: [f64; 2],
    /// Mean of the last values.
    recent: f64,
    /// Weighted sums of the line: 1, t, x, t^2, t x, with times from the last value on.
    line: [f64; 5],
    found: bool,
}

/// A number with the standard deviation that its fit states; 0 where it states none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) deviation: f64,
}

/// What is specific to a quantity.
#[derive(Debug, Clone, Copy)]
pub(super) struct DriftRule {
    /// `s_min`, what else than scatter changes a healthy cable's value.
    pub(super) min_deviation: f64,
    /// `d_min`.
    pub(super) min_drift: f64,
    /// `k` and `h`.
    pub(super) cusum: [f64; 2],
    /// Drift of which the forecast speaks.
    pub(super) limit: f64,
    /// Direction that is wear.
    pub(super) wear: Wear,
}

/// Direction in which a quantity changes where its cable wears; the other one is not reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wear {
    Growth,
    Fall,
    Either,
}

/// Drift of one quantity of a cable, as a fraction of its value in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Since the beginning, 1; 0 until known.
    pub fraction: f64,
    /// Standard error of it, 1; infinite until known.
    pub error: f64,
    /// Whether it is significant.
    pub found: bool,
    /// Time until it reaches its limit, a fifth (of a pretension the half), at its present rate, s; infinite
    /// where it does not grow.
    pub remaining: f64,
}

impl Default for Drift {
    /// Unknown.
    fn default() -> Self {
        Self { fraction: 0.0, error: f64::INFINITY, found: false, remaining: f64::INFINITY }
    }
}

impl Drift {
    /// In standard errors, 1; 0 until known.
    pub(super) fn deviations(&self) -> f64 {
        self.fraction / self.error
    }

    /// Two independent estimates of one drift, weighted by their variances; the forecast is that of the more
    /// precise one, `found` that of `self`.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let [own, others] = [self, other].map(|drift| 1.0 / (drift.error * drift.error));
        let precision = own + others;
        if precision > 0.0 {
            Self {
                fraction: (own * self.fraction + others * other.fraction) / precision,
                error: 1.0 / libm::sqrt(precision),
                found: self.found,
                remaining: if own > others { self.remaining } else { other.remaining },
            }
        } else {
            *self
        }
    }
}

/// `n_0`.
const FIRST: f64 = 8.0;
/// Memory of the recent mean and of the slope, values.
const RECENT: f64 = 4.0;
const SLOPE_MEMORY: f64 = 8.0;
/// Fraction of the stated deviation that counts.
const STATED_FRACTION: f64 = 0.5;
/// Scatter below which two numbers count as equally precise.
const MIN_SCATTER: f64 = 1e-3;
/// Largest step that counts, deviations, and memory of the deviation, values.
const LARGEST_STEP: f64 = 3.0;
const SCATTER_MEMORY: f64 = 64.0;

/// Of the recent mean less that of the first values, per deviation of a value.
fn standard_error() -> f64 {
    libm::sqrt(1.0 / FIRST + 1.0 / (2.0 * RECENT - 1.0))
}

impl DriftWatch {
    pub(super) fn new(rule: DriftRule) -> Self {
        Self {
            rule,
            count: 0.0,
            mean: 0.0,
            squares: 0.0,
            variance: 0.0,
            last: 0.0,
            stated: 0.0,
            sums: [0.0; 2],
            recent: 0.0,
            line: [0.0; 5],
            found: false,
        }
    }

    /// Takes the value of one window, which lasts `window` s.
    pub(super) fn update(&mut self, estimate: Estimate, window: f64) {
        let Estimate { value: x, deviation } = estimate;
        if !x.is_finite() || !deviation.is_finite() {
            return;
        }
        self.count += 1.0;
        let kept = 1.0 - 1.0 / SLOPE_MEMORY;
        let [n, t, v, tt, tv] = self.line;
        // The origin of time moves on to the new value.
        let (tt, tv, t) = (tt - 2.0 * window * t + window * window * n, tv - window * v, t - window * n);
        self.line = [kept * n + 1.0, kept * t, kept * v + x, kept * tt, kept * tv];
        if self.count <= FIRST {
            let d = x - self.mean;
            self.mean += d / self.count;
            self.stated += (deviation - self.stated) / self.count;
            self.squares += d * (x - self.mean);
            self.recent = self.mean;
            (self.variance, self.last) = (self.squares / (FIRST - 1.0), x);
            return;
        }
        let step = x - self.last;
        let square = (0.5 * step * step).min(LARGEST_STEP * LARGEST_STEP * self.variance);
        self.variance += (square - self.variance) / (self.count - 1.0).min(SCATTER_MEMORY);
        self.last = x;
        let z = (x - self.mean) / self.deviation();
        let [allowance, threshold] = self.rule.cusum;
        self.sums = [(self.sums[0] + z - allowance).max(0.0), (self.sums[1] - z - allowance).max(0.0)];
        self.recent += (x - self.recent) / RECENT;
        let [grown, fallen] = self.sums.map(|sum| sum > threshold);
        let drift = self.recent - self.mean;
        self.found |= self.rule.wear != Wear::Fall && grown && drift > self.rule.min_drift;
        self.found |= self.rule.wear != Wear::Growth && fallen && -drift > self.rule.min_drift;
    }

    fn deviation(&self) -> f64 {
        self.scatter().max(self.rule.min_deviation)
    }

    /// `max(s_0, s, s_x/2)`.
    fn scatter(&self) -> f64 {
        libm::sqrt((self.squares / (FIRST - 1.0)).max(self.variance)).max(STATED_FRACTION * self.stated)
    }

    /// The drift over its standard error by scatter alone, 1; 0 until known.
    pub(super) fn significance(&self) -> f64 {
        let error = self.scatter().max(MIN_SCATTER) * standard_error();
        if self.count < FIRST { 0.0 } else { (self.recent - self.mean) / error }
    }

    pub(super) fn drift(&self) -> Drift {
        if self.count < FIRST {
            return Drift::default();
        }
        let fraction = self.recent - self.mean;
        let error = self.deviation() * standard_error();
        let [n, t, v, tt, tv] = self.line;
        let spread = n * tt - t * t;
        let slope = if spread > 0.0 { (n * tv - t * v) / spread } else { 0.0 };
        let toward = slope * fraction.signum();
        let left = self.rule.limit - fraction.abs();
        let remaining = if left <= 0.0 {
            0.0
        } else if self.found && toward > 0.0 {
            left / toward
        } else {
            f64::INFINITY
        };
        Drift { fraction, error, found: self.found, remaining }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use std::vec::Vec;

    fn exact(value: f64) -> Estimate {
        Estimate { value, deviation: 0.0 }
    }

    const RULE: DriftRule = DriftRule {
        min_deviation: 0.005,
        min_drift: 0.02,
        cusum: [1.0, 8.0],
        limit: 0.2,
        wear: Wear::Either,
    };

    /// As the travel is judged: what scatters more than the rule's least deviation.
    const PRECISE: DriftRule = DriftRule { min_deviation: 0.0, min_drift: 0.0, cusum: [2.0, 12.0], ..RULE };

    #[test]
    fn steady_noise_is_hardly_reported_in_a_thousand_series() {
        let mut random = Random::new(5);
        for (rule, most) in [(RULE, 0), (PRECISE, 2)] {
            let reported = (0..1000).filter(|_| {
                let mut watch = DriftWatch::new(rule);
                (0..600).for_each(|_| watch.update(exact(0.03 + 0.005 * random.normal()), 100.0));
                watch.drift().found
            });
            assert!(reported.count() <= most, "{rule:?}");
        }
    }

    #[test]
    fn a_step_is_found_and_does_not_hide_behind_the_scatter_that_it_adds() {
        let mut random = Random::new(6);
        for _ in 0..200 {
            let mut watch = DriftWatch::new(PRECISE);
            (0..16).for_each(|_| watch.update(exact(0.005 * random.normal()), 100.0));
            let windows = (0..10).position(|_| {
                watch.update(exact(0.06 + 0.005 * random.normal()), 100.0);
                watch.drift().found
            });
            assert!(windows.is_some_and(|windows| windows < 4), "{windows:?}");
        }
    }

    #[test]
    fn only_the_direction_of_wear_is_reported() {
        for (wear, sign, found) in [
            (Wear::Growth, 1.0, true),
            (Wear::Growth, -1.0, false),
            (Wear::Fall, 1.0, false),
            (Wear::Fall, -1.0, true),
            (Wear::Either, 1.0, true),
            (Wear::Either, -1.0, true),
        ] {
            let mut watch = DriftWatch::new(DriftRule { wear, ..RULE });
            (0..40).for_each(|k| watch.update(exact(sign * 0.005 * f64::from(k)), 100.0));
            assert_eq!(watch.drift().found, found, "{wear:?} {sign}");
        }
    }

    #[test]
    fn a_ramp_is_found_early_and_its_end_is_foretold() {
        let mut random = Random::new(7);
        for _ in 0..100 {
            let mut watch = DriftWatch::new(RULE);
            let mut found = None;
            for k in 0..44 {
                let worn = 0.2 * (f64::from(k - 8) / 36.0).max(0.0);
                watch.update(exact(0.01 + worn + 0.006 * random.normal()), 100.0);
                if watch.drift().found && found.is_none() {
                    found = Some((worn, watch.drift().remaining));
                }
            }
            let (worn, _) = found.unwrap();
            assert!(worn < 0.1, "{worn}");
            let drift = watch.drift();
            assert!((drift.fraction - 0.19).abs() < 4.0 * drift.error + 0.02, "{drift:?}");
            assert!(drift.remaining < 2500.0, "{drift:?}");
        }
    }

    #[test]
    fn share_error_and_forecast_are_those_of_weighted_sums_over_all_values() {
        let mut random = Random::new(8);
        for case in 0..50 {
            let rule = DriftRule { min_deviation: 1e-3 * f64::from(case % 3), ..RULE };
            let mut watch = DriftWatch::new(rule);
            let rate = if case % 2 == 0 { 0.004 } else { -0.004 };
            let values: Vec<(f64, f64)> = (0..30)
                .map(|k| (rate * f64::from(k) + 5e-4 * random.normal(), 60.0 + 20.0 * random.unit()))
                .collect();
            for (value, window) in &values {
                watch.update(exact(*value), *window);
            }
            let first = values.iter().take(8).map(|(value, _)| value / 8.0).sum::<f64>();
            let recent = values.iter().skip(8).fold(first, |mean, (value, _)| 0.75 * mean + 0.25 * value);
            // Times before the last value, and weights that fade by an eighth for each value.
            let mut sums = [0.0; 5];
            let (mut t, mut weight) = (0.0, 1.0);
            for (value, window) in values.iter().rev() {
                let terms = [1.0, t, *value, t * t, t * value];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
                (t, weight) = (t - window, 0.875 * weight);
            }
            let [n, t, v, tt, tv] = sums;
            let slope = (n * tv - t * v) / (n * tt - t * t);
            let drift = watch.drift();
            assert!(drift.found, "{drift:?}");
            assert!((drift.fraction - (recent - first)).abs() < 1e-12);
            let remaining = (0.2 - drift.fraction.abs()) / slope.abs();
            assert!((drift.remaining / remaining - 1.0).abs() < 1e-9, "{} {remaining}", drift.remaining);
            // Of the mean of eight and of a mean with weights 1/4, 3/16, ...: sum of squares 1/7.
            let scatter = drift.error / libm::sqrt(1.0 / 8.0 + 1.0 / 7.0);
            assert!((drift.deviations() * drift.error / drift.fraction - 1.0).abs() < 1e-12);
            let significance = drift.fraction / (scatter.max(1e-3) * libm::sqrt(1.0 / 8.0 + 1.0 / 7.0));
            assert!((watch.significance() / significance - 1.0).abs() < 1e-9 || rule.min_deviation > 0.0);
        }
    }

    #[test]
    fn the_scatter_of_alternating_values_is_that_of_their_differences() {
        let d = 0.01;
        let mut watch = DriftWatch::new(DriftRule { min_deviation: 0.0, ..RULE });
        for k in 0..40 {
            watch.update(exact(if k % 2 == 0 { d } else { -d }), 100.0);
        }
        // 8/7 d^2 at first; a step of 2 d counts as 2 d^2, with weights 1/8, 1/9, ..., 1/39.
        let square = d * d * (2.0 - (2.0 - 8.0 / 7.0) * 7.0 / 39.0);
        let error = libm::sqrt(square * (1.0 / 8.0 + 1.0 / 7.0));
        assert!((watch.drift().error / error - 1.0).abs() < 1e-12);
        assert!((watch.significance() / (watch.drift().fraction / error) - 1.0).abs() < 1e-12);
        // A step of a hundred deviations counts as one of three.
        watch.update(exact(100.0 * d), 100.0);
        let larger = square + (9.0 - 1.0) * square / 40.0;
        let error = libm::sqrt(larger * (1.0 / 8.0 + 1.0 / 7.0));
        assert!((watch.drift().error / error - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_constant_deviation_is_found_when_its_sum_exceeds_the_threshold_and_its_mean_the_least_drift() {
        // z = 3 a window, 2 of it above the allowance: 8 is exceeded by the fifth, not by the fourth.
        let count = |sign: f64, min_drift: f64| {
            let mut watch = DriftWatch::new(DriftRule { min_drift, ..RULE });
            (0..8).for_each(|_| watch.update(exact(0.0), 100.0));
            (1..40).find(|_| {
                // The difference to the value before would add to the scatter.
                watch.last = sign * 0.015;
                watch.update(exact(sign * 0.015), 100.0);
                watch.drift().found
            })
        };
        for sign in [1.0, -1.0] {
            assert_eq!(count(sign, 1e-3), Some(5));
            // The recent mean has come to 1 - 0.75^n of the step.
            let after = |n: f64| 0.015 * (1.0 - libm::pow(0.75, n));
            assert_eq!(count(sign, 0.5 * (after(7.0) + after(8.0))), Some(8));
            assert_eq!(count(sign, 0.0151), None);
        }
    }

    #[test]
    fn before_eight_values_nothing_is_known_and_what_is_not_finite_does_not_count() {
        let mut watch = DriftWatch::new(RULE);
        for k in 0..7 {
            watch.update(exact(0.1 * f64::from(k)), 100.0);
            watch.update(exact(f64::NAN), 100.0);
            watch.update(Estimate { value: 0.0, deviation: f64::INFINITY }, 100.0);
            let drift = watch.drift();
            assert!(drift.error.is_infinite() && drift.remaining.is_infinite() && !drift.found);
            assert!(drift.fraction.abs() < 1e-300 && watch.significance().abs() < 1e-300);
        }
        watch.update(exact(0.7), 100.0);
        assert!(watch.drift().error.is_finite());
        // The eighth value is still of the beginning.
        assert!(watch.drift().fraction.abs() < 1e-12);
    }

    #[test]
    fn half_of_the_deviation_that_a_fit_states_counts() {
        let mut watch = DriftWatch::new(RULE);
        for k in 0..8 {
            watch.update(Estimate { value: 0.0, deviation: 0.01 * f64::from(k + 1) }, 100.0);
        }
        let error = 0.5 * 0.045 * libm::sqrt(1.0 / 8.0 + 1.0 / 7.0);
        assert!((watch.drift().error / error - 1.0).abs() < 1e-12);
        assert!(watch.significance().abs() < 1e-12);
    }

    #[test]
    fn nothing_remains_beyond_the_limit_and_all_time_without_a_trend() {
        let mut watch = DriftWatch::new(RULE);
        (0..8).for_each(|_| watch.update(exact(0.0), 100.0));
        (0..40).for_each(|_| watch.update(exact(0.25), 100.0));
        assert!(watch.drift().found && watch.drift().remaining.abs() < 1e-300);
        let mut back = DriftWatch::new(RULE);
        (0..8).for_each(|_| back.update(exact(0.0), 100.0));
        (0..40).for_each(|_| back.update(exact(0.15), 100.0));
        // Still worn, but coming back.
        (0..6).for_each(|k| back.update(exact(0.15 - 0.005 * f64::from(k)), 100.0));
        let drift = back.drift();
        assert!(drift.found && drift.fraction > 0.1 && drift.remaining.is_infinite(), "{drift:?}");
    }

    #[test]
    fn two_estimates_of_one_drift_are_weighted_by_their_variances() {
        let one = Drift { fraction: 0.1, error: 0.01, found: true, remaining: 5.0 };
        let other = Drift { fraction: 0.2, error: 0.02, found: false, remaining: 7.0 };
        for (joined, found) in [(one.joined(&other), true), (other.joined(&one), false)] {
            assert!((joined.fraction - (4.0 * 0.1 + 0.2) / 5.0).abs() < 1e-12);
            assert!((joined.error - 0.01 / libm::sqrt(1.25)).abs() < 1e-12);
            assert!((joined.remaining - 5.0).abs() < 1e-12 && joined.found == found);
        }
        let unknown = Drift::default();
        assert_eq!(unknown.joined(&unknown), unknown);
        assert!((unknown.joined(&one).fraction - 0.1).abs() < 1e-12);
    }
}
