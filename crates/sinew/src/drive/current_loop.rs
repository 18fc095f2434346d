use super::motor::Motor;

/// Current loop: the voltage that brings the wanted current in one step, and an integral for what heat has changed.
///
/// ```text
/// u = k w + v,    v = R (i* - e i^)/(1 - e) + z,   z <- z + g R (i* - i^),    e = e^(-h R/L),   |u| <= u_max
/// ```
///
/// | symbol | argument   | unit  | meaning                                              |
/// |--------|------------|-------|------------------------------------------------------|
/// | i*     | `wanted`   | A     | held within the peak current before                     |
/// | i^     | `current`  | A     | as measured at the start of the step                   |
/// | v      |            | V     | what the winding gets beside the voltage its motion makes |
/// | R      |            | ohm   | cold: the drive does not know how warm its winding is     |
/// | g      |            | 1     | 0.2: a warm winding is learned in some milliseconds       |
///
/// Real drives close this loop at 10 to 20 kHz: within a millisecond they follow the speed, so `k w` is that of the
/// shaft as the step ends. A voltage that is held for a millisecond and reaches the same current at its end has the
/// same mean current but for `L/R` of a fraction of a millisecond.
///
/// # Source
/// Dead-beat control of a first-order lag, textbook.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurrentLoop {
    correction: f64,
}

const LEARNING: f64 = 0.2;

impl CurrentLoop {
    /// The voltage of the next step beside what the motion makes, V; `decay` is `e^(-h R/L)`.
    #[inline]
    #[must_use]
    pub fn voltage(&self, motor: &Motor, wanted: f64, current: f64, decay: f64) -> f64 {
        motor.resistance * (wanted - decay * current) / (1.0 - decay).max(1e-6) + self.correction
    }

    /// Learns from what is missing; not where the amplifier gave all it can, or it would be asked for ever more.
    #[inline]
    pub fn learn(&mut self, motor: &Motor, wanted: f64, current: f64) {
        self.correction += LEARNING * motor.resistance * (wanted - current);
    }

    /// Forgets what it has learned.
    pub fn reset(&mut self) {
        self.correction = 0.0;
    }
}
