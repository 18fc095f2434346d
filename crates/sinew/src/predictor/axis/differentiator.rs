//! Rates of a sampled signal, from the past alone.

/// Value, rate and second rate of a signal by a polynomial of degree two fitted to its past with exponentially fading
/// weights.
///
/// ```text
/// p = x + v dt + a dt^2/2,   q = v + a dt,   e = u - p,   theta = tau/(tau + dt)
/// x = p + (1 - theta^3) e
/// v = q + 3/2 (1 - theta)^2 (1 + theta) e/dt
/// a = a + (1 - theta)^3 e/dt^2
/// ```
///
/// | symbol  | meaning                                   | unit        |
/// |---------|-------------------------------------------|-------------|
/// | u       | the signal                                | [u]         |
/// | x, v, a | its value, rate and second rate           | [u], per s, s^2 |
/// | tau     | time over which the past fades             | s, > 0      |
/// | dt      | time since the sample before               | s, >= 0     |
///
/// A signal of constant second rate is followed without lag; noise is attenuated the more, the larger `tau`. The
/// divisions by `dt` cancel: `1 - theta = dt/(tau + dt)`. A sequence may begin in motion: `tau` grows from 0 with a
/// quarter of the time since its start, so that the first samples determine the rates.
///
/// # Departs
/// `theta` is the first-order approximation of `exp(-dt/tau)`.
///
/// # Source
/// `morrison1969`, fading-memory polynomial filter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Differentiator {
    /// `x`, signal unit.
    pub value: f64,
    /// `v`, signal unit per s.
    pub rate: f64,
    /// `a`, signal unit per s^2.
    pub second_rate: f64,
    /// `tau` so far, s.
    memory_s: f64,
}

impl Differentiator {
    /// At the first sample of a sequence.
    #[inline]
    #[must_use]
    pub fn at(signal: f64) -> Self {
        Self { value: signal, ..Self::default() }
    }

    /// Advances by one sample; a `dt_s` that is not positive changes nothing.
    #[inline]
    pub fn step(&mut self, signal: f64, tau_s: f64, dt_s: f64) {
        if dt_s > 0.0 {
            let reach = self.memory_s + dt_s;
            let (theta, rest) = (self.memory_s / reach, dt_s / reach);
            let predicted = self.value + dt_s * (self.rate + 0.5 * dt_s * self.second_rate);
            let error = signal - predicted;
            self.value = predicted + (1.0 - theta * theta * theta) * error;
            self.rate += dt_s * self.second_rate + 1.5 * rest * (1.0 + theta) / reach * error;
            self.second_rate += rest / (reach * reach) * error;
            self.memory_s = tau_s.min(self.memory_s + 0.25 * dt_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Differentiator;

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
        let relative = |got: f64, wanted: f64| (got / wanted - 1.0).abs();
        assert!(relative(found.second_rate, 4.0) < 1e-6, "{found:?}");
        assert!(relative(found.rate, -0.2 + 4.0 * t) < 1e-6, "{found:?}");
        assert!(relative(found.value, parabola(t)) < 1e-9, "{found:?}");
    }

    #[test]
    fn a_sequence_that_begins_in_motion_has_its_rate_long_before_a_memory_has_passed() {
        let mut found = Differentiator::at(1.0);
        for k in 1..=12 {
            found.step(1.0 + 0.3 * 0.001 * f64::from(k), 0.05, 0.001);
        }
        assert!((found.rate - 0.3).abs() < 0.06 && found.second_rate.abs() < 20.0, "{found:?}");
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
}
