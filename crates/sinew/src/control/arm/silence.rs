//! Cycles without any reading, as when no answer comes from the bus: what was rejected in them alone is no
//! sensor's fault.

use super::signals::ArmMeasurement;

/// How long a sensor may take to be accepted again once readings come, s, and at least [`RETURN_CYCLES`].
const RETURN_TIME: f64 = 0.02;
const RETURN_CYCLES: f64 = 5.0;

/// The last cycles in which no sensor gave a reading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Silence {
    /// Time since the first of them, s.
    begun: f64,
    /// Time since the last of them, s.
    ended: f64,
}

impl Silence {
    pub(super) const NONE: Self = Self { begun: f64::INFINITY, ended: f64::INFINITY };

    /// The readings of a cycle, `h` s after those before.
    pub(super) fn follow(&mut self, h: f64, measurement: &ArmMeasurement<'_>) {
        let mut readings = measurement.motor.iter().chain(measurement.tension).chain(measurement.joint);
        let is_silent = readings.all(|reading| reading.is_nan());
        let was_silent = self.ended < 0.5 * h;
        self.begun = if is_silent && !was_silent { h } else { self.begun + h };
        self.ended = if is_silent { 0.0 } else { self.ended + h };
    }

    /// Whether a sensor that has been rejected for this time, s, is so because nothing came.
    pub(super) fn explains(&self, h: f64, rejected_for: f64) -> bool {
        let half = 0.5 * h;
        self.ended <= RETURN_TIME.max(RETURN_CYCLES * h) + half && rejected_for < self.begun + half
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_explains_what_was_rejected_in_it_and_for_a_while() {
        let h = 1e-3;
        let read = |silence: &mut Silence, joint: f64| {
            let (motor, tension) = ([joint], [f64::NAN]);
            silence.follow(h, &ArmMeasurement { motor: &motor, tension: &tension, joint: &[joint] });
        };
        let mut silence = Silence::NONE;
        read(&mut silence, 1.0);
        assert!(!silence.explains(h, h));
        (0..3).for_each(|_| read(&mut silence, f64::NAN));
        assert!(silence.explains(h, 3.0 * h) && !silence.explains(h, 4.0 * h), "rejected before");
        (0..20).for_each(|_| read(&mut silence, 1.0));
        assert!(silence.explains(h, 23.0 * h));
        (0..2).for_each(|_| read(&mut silence, 1.0));
        assert!(!silence.explains(h, 25.0 * h));
    }
}
