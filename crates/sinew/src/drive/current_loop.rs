use super::motor::Motor;
use crate::lanes::abreast;

/// Dead-beat current loop with an integral for the change of resistance with temperature.
///
/// ```text
/// u = k w + v,    v = R (i* - e i^)/(1 - e) + z,   z <- z + g R (i* - i^),    e = e^(-h R/L),   |u| <= u_max
/// ```
///
/// | symbol | argument   | unit  | meaning                                              |
/// |--------|------------|-------|------------------------------------------------------|
/// | i*     | `desired`   | A     | desired, limited to the peak current                     |
/// | i^     | `current`  | A     | as measured at the start of the step                   |
/// | v      |            | V     | winding voltage beside the back-EMF |
/// | R      |            | ohm   | cold: the drive does not measure the temperature of its winding     |
/// | g      |            | 1     | 0.2: a warm winding is compensated within milliseconds       |
///
/// Drives close this loop at 10 to 20 kHz and track the back-EMF within a millisecond, so `k w` is that of
/// the shaft at the end of the step. A voltage held for a millisecond that reaches the same final current has
/// the same mean current up to `L/R`, a fraction of a millisecond.
///
/// # Source
/// Dead-beat control of a first-order lag, textbook.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurrentLoop {
    correction: f64,
}

abreast!(CurrentLoopRows of CurrentLoop { f64: correction });

const INTEGRAL_GAIN: f64 = 0.2;

impl CurrentLoop {
    /// Winding voltage of the next step without the back-EMF, V; `decay` is `e^(-h R/L)`.
    #[inline(always)]
    #[must_use]
    pub fn voltage(&self, motor: &Motor, desired: f64, current: f64, decay: f64) -> f64 {
        motor.resistance * (desired - decay * current) / (1.0 - decay).max(1e-6) + self.correction
    }

    /// Integrates the current error; the caller skips this where the voltage is saturated (anti-windup).
    #[inline(always)]
    pub fn integrate(&mut self, motor: &Motor, desired: f64, current: f64) {
        self.correction += INTEGRAL_GAIN * motor.resistance * (desired - current);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::MotorState;

    #[test]
    fn one_step_brings_a_cold_winding_to_the_desired_current_however_short_it_is() {
        let motor = Motor::class_35_mm();
        for h in [3e-5, 1e-4, 1e-3] {
            for (current, desired) in [(0.0, 5.0), (3.0, -4.0), (-2.0, 0.0)] {
                let mut state = MotorState::cold(&motor);
                state.current = current;
                let decay = state.prepare(&motor, h).left;
                let voltage = CurrentLoop::default().voltage(&motor, desired, current, decay);
                state.drive(voltage, h);
                assert!((state.current - desired).abs() < 1e-13, "{h} {desired}: {}", state.current);
            }
        }
    }
}
