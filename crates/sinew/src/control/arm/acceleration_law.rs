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
    /// `q''_d`, rad/s^2: `[joints]`.
    pub(super) output: Vec<f64>,
    /// `d_u`, rad/s^2: `[joints]`.
    disturbance: Vec<f64>,
}

/// `k_i`, 1.
const INTEGRAL_GAIN: f64 = 0.2;

impl AccelerationLaw {
    pub(super) fn new(joints: usize) -> Self {
        Self { error: vec![0.0; joints], output: vec![0.0; joints], disturbance: vec![0.0; joints] }
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

    /// Error of the estimated angles, rad, (24).
    pub(super) fn update_error(&mut self, reference: &Reference, q: &[f64]) {
        for (error, (reference, q)) in self.error.iter_mut().zip(reference.q.iter().zip(q)) {
            *error = reference - q;
        }
    }

    /// `q''_d` from the errors and the estimated velocities, rad/s, (25) and (26).
    pub(super) fn evaluate(&mut self, gains: &ArmGains, reference: &Reference, v: &[f64], at_rest: bool) {
        for (k, output) in self.output.iter_mut().enumerate() {
            let w = gains.joints[k].bandwidth;
            *output = if at_rest {
                -self.disturbance[k]
            } else {
                reference.a[k] + w * w * self.error[k] + 2.0 * gains.damping * w * (reference.v[k] - v[k])
                    - self.disturbance[k]
            };
        }
    }
}
