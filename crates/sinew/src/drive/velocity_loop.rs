use crate::lanes::abreast;

/// Velocity mode: a reference that respects the acceleration limit, followed by proportional and integral
/// action.
///
/// ```text
/// w_r <- w_r + clamp(w* - w_r, +- a h),    tau = J (dw_r/dt + K (w_r - w^)) + z,    z <- z + h J K^2/4 (w_r - w^)
/// ```
///
/// | symbol | argument       | unit    | meaning                                              |
/// |--------|----------------|---------|------------------------------------------------------|
/// | w*, w^ | `desired`, `speed` | rad/s | speed of the motor, desired and measured                |
/// | a      | `acceleration` | rad/s^2 | limit                                                 |
/// | J      | `inertia`      | kg m^2  | of the rotor                                           |
/// | K      | `gain`         | 1/s     | 150: critically damped, settled in some 30 ms            |
/// | tau    |                | Nm      | at the motor, beside the load feed-forward              |
///
/// Where the torque saturates, the lead of the reference is limited and the integral is held (anti-windup).
///
/// # Source
/// Textbook; the gain is ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityLoop {
    /// 1/s.
    pub gain: f64,
    reference: f64,
    integral: f64,
}

abreast!(VelocityLoopRows of VelocityLoop { f64: gain reference integral });

/// Limits of a velocity loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityLimits {
    /// rad/s^2 at the motor.
    pub acceleration: f64,
    /// Lower and upper limit of the torque beside the load feed-forward, Nm.
    pub torque: [f64; 2],
}

impl VelocityLoop {
    /// `K` of a drive, 1/s.
    pub const DRIVE_GAIN: f64 = 150.0;
    /// `K^2/4` of a drive, 1/s^2: its integral action per inertia.
    pub const DRIVE_INTEGRAL: f64 = 0.25 * Self::DRIVE_GAIN * Self::DRIVE_GAIN;

    /// A loop at rest.
    #[must_use]
    pub fn new(gain: f64) -> Self {
        Self { gain, reference: 0.0, integral: 0.0 }
    }

    /// Bumpless start from the present speed and torque.
    #[inline(always)]
    pub fn take_over(&mut self, speed: f64, torque: f64) {
        self.reference = speed;
        self.integral = torque;
    }

    /// Torque of the next step, Nm.
    #[inline(always)]
    pub fn torque(&mut self, desired: f64, speed: f64, inertia: f64, limits: VelocityLimits, h: f64) -> f64 {
        let most = limits.acceleration * h;
        let change = (desired - self.reference).max(-most).min(most);
        let error = self.reference + change - speed;
        let raw = inertia * (change / h + self.gain * error) + self.integral;
        let given = raw.max(limits.torque[0]).min(limits.torque[1]);
        if given.to_bits() == raw.to_bits() {
            self.reference += change;
            self.integral += h * inertia * 0.25 * self.gain * self.gain * error;
        } else {
            // The reference may lead the shaft by the error at which the proportional part alone saturates.
            let lead = (limits.torque[1] - limits.torque[0]) / (inertia * self.gain);
            self.reference = (self.reference + change).max(speed - lead).min(speed + lead);
        }
        given
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saturated_loop_neither_winds_up_its_integral_nor_lets_its_reference_run_away() {
        let (inertia, h) = (1e-5, 1e-3);
        let limits = VelocityLimits { acceleration: 1e5, torque: [-0.1, 0.1] };
        let mut velocity_loop = VelocityLoop::new(150.0);
        // A blocked shaft, for a second; then it is to stand.
        for _ in 0..1000 {
            let torque = velocity_loop.torque(500.0, 0.0, inertia, limits, h);
            assert!((torque - 0.1).abs() < 1e-12);
        }
        let torques: [f64; 4] = core::array::from_fn(|_| velocity_loop.torque(0.0, 0.0, inertia, limits, h));
        // The reference leads by at most 133 rad/s and falls by 100 rad/s in a millisecond.
        assert!(torques[3].abs() < 0.01, "{torques:?}");
    }

    #[test]
    fn a_shaft_that_follows_its_ramp_gets_the_torque_taken_over_and_that_of_its_inertia() {
        let (inertia, h, acceleration, load) = (1e-5, 1e-3, 2000.0, 0.03);
        let limits = VelocityLimits { acceleration, torque: [-1.0, 1.0] };
        for sign in [1.0, -1.0] {
            let mut velocity_loop = VelocityLoop::new(150.0);
            velocity_loop.take_over(40.0, load);
            for k in 1..=8 {
                // Five steps to a speed that is 10 rad/s off, then it is held.
                let speed = 40.0 + sign * acceleration * h * f64::from(k.min(5));
                let torque = velocity_loop.torque(40.0 + 10.0 * sign, speed, inertia, limits, h);
                let expected = load + if k <= 5 { sign * inertia * acceleration } else { 0.0 };
                assert!((torque - expected).abs() < 1e-12, "{k}: {torque} {expected}");
            }
        }
    }

    #[test]
    fn a_reference_leads_a_blocked_shaft_by_the_error_that_saturates_the_torque_from_end_to_end() {
        let (inertia, gain, h, speed) = (1e-5, 150.0, 1e-3, 50.0);
        let limits = VelocityLimits { acceleration: 1e5, torque: [-0.2, 0.1] };
        for desired in [5000.0, -5000.0] {
            let mut velocity_loop = VelocityLoop::new(gain);
            for _ in 0..20 {
                velocity_loop.torque(desired, speed, inertia, limits, h);
            }
            let lead = velocity_loop.reference - speed;
            assert!((inertia * gain * lead.abs() - 0.3).abs() < 1e-12, "{lead}");
            assert!(lead * desired > 0.0);
        }
    }
}
