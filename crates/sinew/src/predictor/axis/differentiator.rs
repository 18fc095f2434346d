//! Rates of a sampled signal, from the past alone.

/// Value, rate and second rate of a signal by a polynomial of degree two fitted to its past: at first to all
/// of it with equal weights, later with exponentially fading ones.
///
/// ```text
/// p = x + v dt + a dt^2/2,   q = v + a dt,   e = u - p,   theta = tau/(tau + dt)
/// x = p + alpha e,   v = q + beta e/dt,   a = a + gamma e/dt^2
///
///                    alpha                          beta                           gamma
/// n = 1              1                              1                              0
/// n < 3.2/(1-theta)  3 (3 n^2 + 3 n + 2)/N          18 (2 n + 1)/N                 60/N       N = (n+1) (n+2) (n+3)
/// then               1 - theta^3                    3/2 (1 - theta)^2 (1 + theta)  (1 - theta)^3
/// ```
///
/// | symbol  | meaning                                   | unit        |
/// |---------|-------------------------------------------|-------------|
/// | u       | the signal                                | \[u\]         |
/// | x, v, a | its value, rate and second rate           | \[u\], per s, s^2 |
/// | tau     | time over which the past fades             | s, > 0      |
/// | dt      | time since the sample before               | s, >= 0     |
/// | n       | samples since the first                    | 1           |
///
/// A signal of constant second rate is followed without lag, from its third sample on where samples are
/// evenly spaced; noise is attenuated the more, the larger `tau`. At `n = 3.2/(1 - theta)` both have the same
/// variance. Samples closer than a thousandth of `tau` are left out, which bounds the divisions by `dt`.
///
/// # Departs
/// `theta` is the first-order approximation of `exp(-dt/tau)`. The equal weights are those of even samples.
///
/// # Source
/// `morrison1969`, expanding-memory and fading-memory polynomial filters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Differentiator {
    /// `x`, signal unit.
    pub value: f64,
    /// `v`, signal unit per s.
    pub rate: f64,
    /// `a`, signal unit per s^2.
    pub second_rate: f64,
    /// Time since the last sample that was used, s.
    since_s: f64,
    /// `n`.
    samples: u32,
}

/// Least `dt` over `tau`.
const MIN_INTERVAL: f64 = 1e-3;

/// Beyond it, which wild intervals alone reach, a polynomial begins anew.
const LARGEST: f64 = 1e60;

/// `n (1 - theta)` from which the past fades.
const FADES: f64 = 3.2;

impl Differentiator {
    /// At the first sample of a sequence.
    #[inline]
    #[must_use]
    pub fn at(signal: f64) -> Self {
        Self { value: signal, ..Self::default() }
    }

    /// Advances by one sample.
    #[inline]
    pub fn step(&mut self, signal: f64, tau_s: f64, dt_s: f64) {
        self.since_s += dt_s;
        let dt_s = self.since_s;
        if dt_s < MIN_INTERVAL * tau_s {
            return;
        }
        self.since_s = 0.0;
        self.samples = self.samples.saturating_add(1);
        let n = f64::from(self.samples);
        let (theta, rest) = (tau_s / (tau_s + dt_s), dt_s / (tau_s + dt_s));
        let [alpha, beta, gamma] = if self.samples == 1 {
            [1.0, 1.0, 0.0]
        } else if n * rest < FADES {
            let product = (n + 1.0) * (n + 2.0) * (n + 3.0);
            [3.0 * (3.0 * n * n + 3.0 * n + 2.0), 18.0 * (2.0 * n + 1.0), 60.0].map(|gain| gain / product)
        } else {
            [1.0 - theta * theta * theta, 1.5 * rest * rest * (1.0 + theta), rest * rest * rest]
        };
        let predicted = self.value + dt_s * (self.rate + 0.5 * dt_s * self.second_rate);
        let error = signal - predicted;
        self.value = predicted + alpha * error;
        self.rate += dt_s * self.second_rate + beta * error / dt_s;
        self.second_rate += gamma * error / (dt_s * dt_s);
        if !(self.value.abs() < LARGEST && self.rate.abs() < LARGEST && self.second_rate.abs() < LARGEST) {
            *self = Self::at(signal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Differentiator;
    use alloc::vec::Vec;

    #[test]
    fn a_parabola_is_followed_without_lag_at_uneven_samples() {
        let parabola = |t: f64| 0.3 - 0.2 * t + 0.5 * 4.0 * t * t;
        let mut found = Differentiator::at(parabola(0.0));
        let mut t = 0.0;
        for k in 0..4000 {
            let dt = if k % 3 == 0 { 0.0005 } else { 0.0015 };
            t += dt;
            found.step(parabola(t), 0.02, dt);
        }
        let relative = |got: f64, desired: f64| (got / desired - 1.0).abs();
        assert!(relative(found.second_rate, 4.0) < 1e-6, "{found:?}");
        assert!(relative(found.rate, -0.2 + 4.0 * t) < 1e-6, "{found:?}");
        assert!(relative(found.value, parabola(t)) < 1e-9, "{found:?}");
    }

    #[test]
    fn a_sequence_that_begins_in_motion_has_its_rates_from_the_third_sample_on() {
        for second_rate in [0.0, 40.0] {
            let (mut found, dt) = (Differentiator::at(1.0), 0.001);
            for k in 1..=200 {
                let t = dt * f64::from(k);
                found.step(1.0 + 0.3 * t + 0.5 * second_rate * t * t, 0.01, dt);
                assert!(found.rate.abs() < 0.4 + 10.0 * t * second_rate, "{k}: {found:?}");
                if k >= 2 {
                    assert!((found.rate - 0.3 - second_rate * t).abs() < 1e-9, "{k}: {found:?}");
                    assert!((found.second_rate - second_rate).abs() < 1e-6, "{k}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn noise_is_attenuated_more_by_a_longer_memory_and_no_interval_changes_nothing() {
        let spread = |tau_s: f64| {
            let mut found = Differentiator::at(0.0);
            let mut sum = 0.0;
            for k in 0..4000_u32 {
                found.step(f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5, tau_s, 0.001);
                sum += if k < 2000 { 0.0 } else { found.second_rate * found.second_rate };
            }
            sum
        };
        assert!(spread(0.02) < 0.1 * spread(0.01));
        let mut still = Differentiator::at(1.0);
        still.step(5.0, 0.01, 0.0);
        assert_eq!(still, Differentiator::at(1.0));
    }

    #[test]
    fn intervals_of_any_size_leave_finite_rates() {
        let mut found = Differentiator::at(0.0);
        for k in 0..10_000_u32 {
            let draw = k.wrapping_mul(2_654_435_761) >> 8;
            let dt = [0.0, 5e-324, 1e-15, 1e-9, 1e-3, 1.0, 1e30][(draw % 7) as usize];
            found.step(if draw % 2 == 0 { 1e30 } else { -1e30 }, 1e-6, dt);
            assert!((1e30 * found.second_rate).is_finite() && found.value.is_finite(), "{k}: {found:?}");
        }
    }

    /// Value, rate and second rate at the last of even samples by least squares with weights `fading^age`.
    fn fitted(signal: &[f64], fading: f64, dt: f64) -> [f64; 3] {
        let (mut moments, mut sums) = ([0.0; 5], [0.0; 3]);
        for (age, u) in signal.iter().rev().enumerate() {
            let (t, mut weight) = (-(age as f64), fading.powi(age as i32));
            for k in 0..5 {
                moments[k] += weight;
                if k < 3 {
                    sums[k] += weight * u;
                }
                weight *= t;
            }
        }
        // Three normal equations, solved by Cramer's rule.
        let matrix = |column: Option<usize>| {
            let m = |i: usize, j: usize| if column == Some(j) { sums[i] } else { moments[i + j] };
            m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1))
                - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
                + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0))
        };
        let [a, b, c] = [0, 1, 2].map(|column| matrix(Some(column)) / matrix(None));
        [a, b / dt, 2.0 * c / (dt * dt)]
    }

    /// Numbers between -1 and 1.
    fn noise(count: u32) -> Vec<f64> {
        (0..count).map(|k| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0).collect()
    }

    #[test]
    fn the_polynomial_is_that_of_least_squares_first_of_all_samples_and_then_of_the_fading_past() {
        let (dt, signal) = (0.25, noise(600));
        for (tau, samples, fading, bound) in [(40.0, 100, 1.0, 5e-14), (2.5, 600, 10.0 / 11.0, 2e-14)] {
            let mut found = Differentiator::at(signal[0]);
            for k in 1..samples {
                found.step(signal[k], tau, dt);
                // Equal weights while n dt/(tau + dt) < 3.2; the others have forgotten them after 40 tau.
                if k >= 3 && (fading < 1.0) == (k > 450) {
                    let [value, rate, second_rate] = fitted(&signal[..=k], fading, dt);
                    let errors = [found.value - value, found.rate - rate, found.second_rate - second_rate];
                    assert!(errors.iter().all(|error| error.abs() < bound), "{k}: {errors:?}");
                }
            }
        }
    }

    #[test]
    fn a_rate_beyond_all_measure_begins_the_polynomial_anew() {
        let mut found = Differentiator::at(0.0);
        // An interval of 1e-20 s makes of a moderate jump an enormous second rate, and only of that one.
        for signal in [1e30, -1e30] {
            found.step(signal, 1e-18, 1e-20);
        }
        assert_eq!(found, Differentiator::at(-1e30));
        // One of 1e-31 s makes an enormous rate at once, before there is a second one.
        let mut found = Differentiator::at(0.0);
        found.step(1e30, 1e-29, 1e-31);
        assert_eq!(found, Differentiator::at(1e30));
    }
}
