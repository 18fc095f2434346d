use crate::lanes::abreast;

/// Tension mode: the error of the tension becomes a speed of the winch (admittance), for the velocity loop
/// beneath.
///
/// ```text
/// v* = v_f + c dT*/dt + g (T* - T^) + z,    z <- z + h g/t_i (T* - T^),    |z| <= v_z
/// ```
///
/// | symbol | argument    | unit    | meaning                                                           |
/// |--------|-------------|---------|-------------------------------------------------------------------|
/// | T*, T^ | `desired`, `measured` | N | at the drive's outlet                                              |
/// | v_f    | `feed`      | m/s     | feed-forward speed of the cable, + toward the motor           |
/// | g      | `gain`      | m/(N s) | 2e-3: with a cable of 24 N/mm a bandwidth of 48 rad/s                  |
/// | t_i    | `reset_time` | s      | 0.5                                                                |
/// | c      | `compliance` | m/N    | of the cable at the drive; 0 where it is unknown                |
///
/// A torque proportional to the tension error, as in the paper, accelerates 100 to 300 kg of reflected rotor
/// inertia against the spring of the cable: the loop oscillates at about 13 rad/s for any gain. A speed
/// command avoids this.
///
/// # Departs
/// `yuan2023` commands the current from the tension error.
///
/// # Source
/// Admittance control, textbook; numbers ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TensionLoop {
    /// m/(N s).
    pub gain: f64,
    /// Time constant of the integral, s.
    pub reset_time: f64,
    /// m/N.
    pub compliance: f64,
    integral: f64,
    /// Last command, N; NaN after a reset.
    last: f64,
}

abreast!(TensionLoopRows of TensionLoop { f64: gain reset_time compliance integral last });

/// Limit of the integral, m/s.
const INTEGRAL_LIMIT: f64 = 0.05;

impl TensionLoop {
    /// A loop in its initial state.
    #[must_use]
    pub fn new(gain: f64, reset_time: f64, compliance: f64) -> Self {
        Self { gain, reset_time, compliance, integral: 0.0, last: f64::NAN }
    }

    /// That of a drive.
    #[must_use]
    pub fn of_drive() -> Self {
        Self::new(2e-3, 0.5, 0.0)
    }

    /// Resets the integral and the derivative of the command.
    #[inline(always)]
    pub fn reset(&mut self) {
        (self.integral, self.last) = (0.0, f64::NAN);
    }

    /// Speed of the winch for the next step, m/s, + toward the motor.
    #[inline(always)]
    pub fn speed(&mut self, desired: f64, measured: f64, feed: f64, h: f64) -> f64 {
        let rate = if self.last.is_nan() { 0.0 } else { (desired - self.last) / h };
        self.last = desired;
        let error = desired - measured;
        self.integral += h * self.gain / self.reset_time * error;
        self.integral = self.integral.clamp(-INTEGRAL_LIMIT, INTEGRAL_LIMIT);
        feed + self.compliance * rate + self.gain * error + self.integral
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_that_of_feed_ramp_error_and_integral_and_after_a_reset_again() {
        let (gain, reset_time, compliance) = (3e-3, 0.4, 5e-5);
        let (feed, error, rate, h) = (0.02, 10.0, 2000.0, 1e-3);
        let mut tension_loop = TensionLoop::new(gain, reset_time, compliance);
        for _ in 0..2 {
            for k in 0..50 {
                let desired = 100.0 + rate * h * f64::from(k);
                let speed = tension_loop.speed(desired, desired - error, feed, h);
                // At first there is no earlier command to take the rate from.
                let stretching = if k == 0 { 0.0 } else { compliance * rate };
                let integral = gain / reset_time * error * h * f64::from(k + 1);
                let expected = feed + stretching + gain * error + integral;
                assert!((speed - expected).abs() < 1e-12, "{k}: {speed} {expected}");
            }
            tension_loop.reset();
        }
    }

    #[test]
    fn the_integral_is_at_most_50_millimetres_per_second_either_way() {
        for error in [400.0, -400.0] {
            let mut tension_loop = TensionLoop::of_drive();
            let mut speed = 0.0;
            for _ in 0..1000 {
                speed = tension_loop.speed(500.0, 500.0 - error, 0.0, 1e-3);
            }
            let integral = speed - tension_loop.gain * error;
            assert!((integral - 0.05_f64.copysign(error)).abs() < 1e-12, "{integral}");
        }
    }
}
