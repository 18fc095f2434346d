use super::gains::ArmGains;
use alloc::vec;
use alloc::vec::Vec;

/// What the joints do and what disturbs them: one extended state observer per joint.
///
/// ```text
/// e = q_m - q^;   w = w_o clip(|e|/e_0, 1, r);   q^ += h (q'^ + 3 w e);   q'^ += h (a + d^ + 3 w^2 e);   d^ += h w^3 e
/// ```
///
/// | symbol | meaning                                                             | unit    |
/// |--------|---------------------------------------------------------------------|---------|
/// | q_m    | joint as its encoder has it                                           | rad     |
/// | a      | acceleration by the model under the tensions that the cables are believed to have | rad/s^2 |
/// | d^     | what is left: masses, friction, tensions that are believed wrongly      | rad/s^2 |
/// | w_o    | bandwidth                                                            | rad/s   |
/// | e_0, r | error from which on it hurries, and how much at most                   | rad, 1  |
///
/// Counts of an encoder are passed slowly; a joint that breaks away from its cables' friction is seen at once.
///
/// # Source
/// Textbook: Luenberger's observer with a disturbance for a third state, all poles at `-w_o`.
#[derive(Debug, Clone)]
pub(super) struct JointObserver {
    bandwidth: f64,
    innovation_threshold: f64,
    max_bandwidth_ratio: f64,
    /// Pose, rad.
    pub(super) q: Vec<f64>,
    /// Velocity, rad/s.
    pub(super) v: Vec<f64>,
    /// Disturbance, rad/s^2.
    pub(super) disturbance: Vec<f64>,
}

impl JointObserver {
    pub(super) fn new(joints: usize, gains: &ArmGains) -> Self {
        let ArmGains { observer_bandwidth: bandwidth, innovation_threshold, max_bandwidth_ratio, .. } =
            *gains;
        Self {
            bandwidth,
            innovation_threshold,
            max_bandwidth_ratio,
            q: vec![0.0; joints],
            v: vec![0.0; joints],
            disturbance: vec![0.0; joints],
        }
    }

    /// Begins at rest.
    pub(super) fn start(&mut self, measured: &[f64]) {
        self.q.copy_from_slice(measured);
        self.v.fill(0.0);
        self.disturbance.fill(0.0);
    }

    pub(super) fn step(&mut self, h: f64, measured: &[f64], acceleration: &[f64]) {
        for (k, (measured, a)) in measured.iter().zip(acceleration).enumerate() {
            let e = measured - self.q[k];
            let w =
                self.bandwidth * (e.abs() / self.innovation_threshold).clamp(1.0, self.max_bandwidth_ratio);
            self.q[k] += h * (self.v[k] + 3.0 * w * e);
            self.v[k] += h * (a + self.disturbance[k] + 3.0 * w * w * e);
            self.disturbance[k] += h * w * w * w * e;
        }
    }
}
