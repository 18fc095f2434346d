use super::motor::Motor;

/// Current loop: the voltage that brings the wanted current in one step, and an integral for what heat has changed.
///
/// ```text
/// u = k w^ + R (i* - e i^)/(1 - e) + z,   z <- z + g R (i* - i^),    e = e^(-h R/L),   |u| <= u_max
/// ```
///
/// | symbol | argument   | unit  | meaning                                              |
/// |--------|------------|-------|------------------------------------------------------|
/// | i*     | `wanted`   | A     | held within the peak current before                     |
/// | i^, w^ | `current`, `speed` | A, rad/s | as measured at the start of the step           |
/// | R      |            | ohm   | cold: the drive does not know how warm its winding is     |
/// | g      |            | 1     | 0.2: a warm winding is learned in some milliseconds       |
///
/// Real drives close this loop at 10 to 20 kHz. A voltage that is held for a millisecond and reaches the same current
/// at its end has the same mean current but for `L/R` of a fraction of a millisecond.
///
/// # Source
/// Dead-beat control of a first-order lag, textbook.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurrentLoop {
    correction: f64,
}

const LEARNING: f64 = 0.2;

impl CurrentLoop {
    /// The voltage of the next step; `decay` is `e^(-h R/L)`.
    #[inline]
    pub fn voltage(&mut self, motor: &Motor, wanted: f64, current: f64, speed: f64, decay: f64) -> f64 {
        let wanted = wanted.max(-motor.peak_current).min(motor.peak_current);
        let raw = motor.torque_constant * speed
            + motor.resistance * (wanted - decay * current) / (1.0 - decay).max(1e-6)
            + self.correction;
        let given = raw.max(-motor.voltage).min(motor.voltage);
        // What the amplifier cannot give must not be asked for more and more.
        if (given - raw).abs() < f64::EPSILON * motor.voltage {
            self.correction += LEARNING * motor.resistance * (wanted - current);
        }
        given
    }

    /// Forgets what it has learned.
    pub fn reset(&mut self) {
        self.correction = 0.0;
    }
}
