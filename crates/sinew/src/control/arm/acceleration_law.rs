use super::gains::ArmGains;
use crate::trajectory::Reference;
use alloc::vec;
use alloc::vec::Vec;

/// Desired acceleration of the joints: reference, error feedback, compensation of the disturbance.
///
/// ```text
/// q''_d = q''_r + w^2 (q_r - q^) + 2 zeta w (q'_r - q'^) - d_u,      at rest  q''_d = -d_u
/// d_u'  = w_d (d^ - d_u)                  with estimated far tensions, at rest 0
/// d_u'  = -k_i w^3 (q_r - q^)             without: integral feedback instead of the observer's disturbance
/// ```
///
/// | symbol  | meaning                                                  | unit         |
/// |---------|----------------------------------------------------------|--------------|
/// | q^, q'^ | estimated angle and velocity                              | rad, rad/s   |
/// | d^, d_u | estimated disturbance, and what of it is compensated        | rad/s^2      |
/// | w, zeta, w_d | [`ArmGains`]                                         | rad/s, 1, rad/s |
/// | k_i     | [`INTEGRAL_GAIN`]                                         | 1            |
///
/// # Departs
/// `yuan2023` feeds errors of muscle lengths back, (24) to (26), with the sign of the velocity term printed
/// wrong; this law has its form, `A = w^2`, `B = 2 zeta w`, in joint space, and adds the disturbance.
///
/// # Source
/// `yuan2023`, eqs. 24 to 26, corrected; disturbance compensation as in any extended state observer.
#[derive(Debug, Clone)]
pub(super) struct AccelerationLaw {
    /// `q_r - q^`, rad: `[joints]`.
    pub(super) error: Vec<f64>,
    /// `q'_r - q'^`, rad/s: `[joints]`.
    pub(super) speed_error: Vec<f64>,
    /// `q''_d`, rad/s^2: `[joints]`.
    pub(super) output: Vec<f64>,
    /// `d_u`, rad/s^2: `[joints]`.
    disturbance: Vec<f64>,
}

/// `k_i`, 1.
const INTEGRAL_GAIN: f64 = 0.2;

impl AccelerationLaw {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            error: vec![0.0; joints],
            speed_error: vec![0.0; joints],
            output: vec![0.0; joints],
            disturbance: vec![0.0; joints],
        }
    }

    /// Starts with an estimated disturbance, rad/s^2, where it is compensated at all.
    pub(super) fn initialize(&mut self, gains: &ArmGains, estimated: &[f64]) {
        let estimated = gains.joints.iter().zip(estimated);
        self.disturbance
            .iter_mut()
            .zip(estimated)
            .for_each(|(used, (gains, d))| *used = if gains.disturbance_bandwidth > 0.0 { *d } else { 0.0 });
    }

    /// One step of `d_u`, `h` s; without an estimate the errors of the last control cycle are integrated.
    pub(super) fn update_disturbance(&mut self, h: f64, gains: &ArmGains, estimated: Option<&[f64]>) {
        for (k, used) in self.disturbance.iter_mut().enumerate() {
            *used += match estimated {
                Some(estimated) => h * gains.joints[k].disturbance_bandwidth * (estimated[k] - *used),
                None => {
                    let w = gains.joints[k].bandwidth;
                    -h * INTEGRAL_GAIN * w * w * w * self.error[k]
                }
            };
        }
    }

    /// Errors of the estimated angles, rad, and velocities, rad/s, (24).
    pub(super) fn update_error(&mut self, reference: &Reference, q: &[f64], v: &[f64]) {
        for (error, (reference, q)) in self.error.iter_mut().zip(reference.q.iter().zip(q)) {
            *error = reference - q;
        }
        for (error, (reference, v)) in self.speed_error.iter_mut().zip(reference.v.iter().zip(v)) {
            *error = reference - v;
        }
    }

    /// `q''_d` from the errors, (25) and (26).
    pub(super) fn evaluate(&mut self, gains: &ArmGains, reference: &Reference, at_rest: bool) {
        for (k, output) in self.output.iter_mut().enumerate() {
            let w = gains.joints[k].bandwidth;
            *output = if at_rest {
                -self.disturbance[k]
            } else {
                reference.a[k] + w * w * self.error[k] + 2.0 * gains.damping * w * self.speed_error[k]
                    - self.disturbance[k]
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two joints with bandwidths of 3 and 5 rad/s, the second without compensation of disturbances.
    fn gains() -> ArmGains {
        let mut gains = ArmGains::for_tests(1, 2);
        gains.damping = 0.7;
        (gains.joints[0].bandwidth, gains.joints[0].disturbance_bandwidth) = (3.0, 8.0);
        (gains.joints[1].bandwidth, gains.joints[1].disturbance_bandwidth) = (5.0, 0.0);
        gains
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * (1.0 + b.abs())
    }

    #[test]
    fn the_compensated_disturbance_starts_with_the_estimate_where_there_is_compensation() {
        let mut law = AccelerationLaw::new(2);
        law.disturbance.fill(7.0);
        law.initialize(&gains(), &[-1.5, 2.5]);
        assert!(near(law.disturbance[0], -1.5) && near(law.disturbance[1], 0.0), "{:?}", law.disturbance);
    }

    #[test]
    fn a_constant_estimate_is_compensated_with_the_time_constant_of_its_bandwidth() {
        let (mut law, gains, h) = (AccelerationLaw::new(2), gains(), 1e-5);
        law.initialize(&gains, &[1.0, 1.0]);
        for _ in 0..10_000 {
            law.update_disturbance(h, &gains, Some(&[4.0, 4.0]));
        }
        // 0.1 s on; the step of Euler's method costs w_d h/2 of the exponent.
        let expected = 4.0 - 3.0 * libm::exp(-8.0 * 0.1);
        assert!((law.disturbance[0] - expected).abs() < 8e-5, "{} {expected}", law.disturbance[0]);
        assert!(near(law.disturbance[1], 0.0), "without a bandwidth nothing is compensated");
    }

    #[test]
    fn without_an_estimate_a_constant_error_is_integrated_with_the_third_power_of_the_bandwidth() {
        let (mut law, gains) = (AccelerationLaw::new(2), gains());
        let reference = Reference { q: vec![0.3, -0.1], ..Reference::new(2) };
        law.update_error(&reference, &[0.1, 0.1], &[0.0; 2]);
        assert!(near(law.error[0], 0.2) && near(law.error[1], -0.2), "{:?}", law.error);
        for _ in 0..50 {
            law.update_disturbance(0.01, &gains, None);
        }
        // Half a second of a fifth of w^3 times the error, against it.
        assert!(near(law.disturbance[0], -0.5 * 0.2 * 27.0 * 0.2), "{:?}", law.disturbance);
        assert!(near(law.disturbance[1], 0.5 * 0.2 * 125.0 * 0.2), "{:?}", law.disturbance);
    }

    #[test]
    fn each_term_of_the_desired_acceleration_has_its_own_gain_and_at_rest_only_the_disturbance_counts() {
        let gains = gains();
        let of = |a: f64, error: f64, speed_error: f64, disturbance: f64, at_rest: bool| {
            let mut law = AccelerationLaw::new(2);
            let reference = Reference { q: vec![0.0; 2], v: vec![2.0 + speed_error; 2], a: vec![a; 2] };
            law.disturbance.fill(disturbance);
            law.update_error(&reference, &[-error; 2], &[2.0; 2]);
            law.evaluate(&gains, &reference, at_rest);
            law.output
        };
        for (k, w) in [3.0, 5.0].into_iter().enumerate() {
            assert!(near(of(1.5, 0.0, 0.0, 0.0, false)[k], 1.5));
            assert!(near(of(0.0, 0.2, 0.0, 0.0, false)[k], w * w * 0.2));
            assert!(near(of(0.0, 0.0, -0.3, 0.0, false)[k], -2.0 * 0.7 * w * 0.3));
            assert!(near(of(0.0, 0.0, 0.0, 4.0, false)[k], -4.0));
            // They add up.
            let sum = 1.5 + w * w * 0.2 - 2.0 * 0.7 * w * 0.3 - 4.0;
            assert!(near(of(1.5, 0.2, -0.3, 4.0, false)[k], sum));
            assert!(near(of(1.5, 0.2, -0.3, 4.0, true)[k], -4.0));
        }
    }
}
