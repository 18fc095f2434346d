use super::design::{Design, Limit};
use alloc::vec::Vec;

/// Largest tension, and the limit that bounds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// N, >= 0.
    pub tension: f64,
    /// The active limit.
    pub limit: Limit,
}

/// Tension limits of a drive at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopePoint {
    /// Of the cable, m/s, + wound in.
    pub speed: f64,
    /// In continuous operation.
    pub continuous: Bound,
    /// At the peak.
    pub peak: Bound,
}

impl Design {
    /// Tension limits at a cable speed (+ wound in, - paid out) and acceleration, m/s and m/s^2.
    ///
    /// The continuous bound is the winding's heat or the reducer's continuous torque; the acceleration enters
    /// the peak only.
    #[must_use]
    pub fn envelope_at(&self, speed: f64, acceleration: f64) -> EnvelopePoint {
        let continuous =
            self.bound(speed, 0.0, (self.continuous_current(), Limit::Heat), self.continuous_torque);
        let peak =
            self.bound(speed, acceleration, (self.motor.peak_current, Limit::Current), self.peak_torque);
        EnvelopePoint { speed, continuous, peak }
    }

    /// The envelope at `points` even speeds from the fastest paid out to the fastest wound in, at least two.
    #[must_use]
    pub fn envelope(&self, points: usize) -> Vec<EnvelopePoint> {
        let points = points.max(2);
        let most = self.top_speed / self.turns();
        let speed = |k: usize| most * (2.0 * k as f64 / (points - 1) as f64 - 1.0);
        (0..points).map(|k| self.envelope_at(speed(k), 0.0)).collect()
    }

    /// Largest acceleration of the cable, m/s^2, at a tension and a speed; negative where the tension is not
    /// reached.
    #[must_use]
    pub fn acceleration(&self, tension: f64, speed: f64) -> f64 {
        let m = &self.motor;
        let torque = m.torque_constant * m.peak_current.min(self.current_by_voltage(speed));
        (torque - self.motor_torque(tension, speed, 0.0)) / (m.inertia * self.turns())
    }

    /// Current within the voltage limit at a cable speed, A, with a hot winding.
    fn current_by_voltage(&self, speed: f64) -> f64 {
        let m = &self.motor;
        (m.voltage - m.torque_constant * speed * self.turns()) / m.resistance_at(m.hottest)
    }

    fn bound(&self, speed: f64, acceleration: f64, current: (f64, Limit), torque: f64) -> Bound {
        // The largest speed is part of the envelope.
        if (speed * self.turns()).abs() > self.top_speed * (1.0 + 1e-12) {
            return Bound { tension: 0.0, limit: Limit::Speed };
        }
        let pulled = |amperes: f64| self.tension(self.motor.torque_constant * amperes, speed, acceleration);
        let bounds = [
            Bound { tension: pulled(current.0), limit: current.1 },
            Bound { tension: pulled(self.current_by_voltage(speed)), limit: Limit::Voltage },
            Bound { tension: torque / self.arm(), limit: Limit::ReducerTorque },
        ];
        bounds.into_iter().fold(bounds[0], |a, b| if b.tension < a.tension { b } else { a })
    }
}
