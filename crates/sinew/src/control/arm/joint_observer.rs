use super::gains::ArmGains;
use alloc::vec;
use alloc::vec::Vec;

/// Angle, velocity and disturbance of every joint: one extended state observer per joint.
///
/// ```text
/// e = q_m - q^,   w = w_o clip(|e|/e_0, 1, r)
/// q^ += h (q'^ + 3 w e),   q'^ += h (a + d^ + 3 w^2 e),   d^ += h w^3 e
/// ```
///
/// | symbol | meaning                                                                     | unit    |
/// |--------|-----------------------------------------------------------------------------|---------|
/// | q_m    | measured angle                                                              | rad     |
/// | a      | acceleration by the model under the estimated tensions, (23) with `d = 0`     | rad/s^2 |
/// | d^     | disturbance: errors of masses, friction and tensions, `M^-1 (-d)` of (23)      | rad/s^2 |
/// | w_o    | bandwidth                                                                   | rad/s   |
/// | e_0, r | threshold of the innovation above which the bandwidth grows, largest growth   | rad, 1  |
///
/// Without a measurement, `e = 0`: the joint moves on its model. The low bandwidth filters the encoder's quantisation; the high one follows a joint that breaks away from
/// stiction.
///
/// # Source
/// Textbook: Luenberger's observer with the disturbance as third state, all poles at `-w`.
#[derive(Debug, Clone)]
pub(super) struct JointObserver {
    bandwidth: f64,
    innovation_threshold: f64,
    max_bandwidth_ratio: f64,
    /// `q^`, rad: `[joints]`.
    pub(super) q: Vec<f64>,
    /// `q'^`, rad/s: `[joints]`.
    pub(super) v: Vec<f64>,
    /// `d^`, rad/s^2: `[joints]`.
    pub(super) disturbance: Vec<f64>,
}

impl JointObserver {
    pub(super) fn new(joints: usize, gains: &ArmGains) -> Self {
        Self {
            bandwidth: gains.observer_bandwidth,
            innovation_threshold: gains.innovation_threshold,
            max_bandwidth_ratio: gains.max_bandwidth_ratio,
            q: vec![0.0; joints],
            v: vec![0.0; joints],
            disturbance: vec![0.0; joints],
        }
    }

    /// Sets the state to the measured angles at rest, without disturbance.
    pub(super) fn initialize(&mut self, measured: &[f64]) {
        self.q.copy_from_slice(measured);
        self.v.fill(0.0);
        self.disturbance.fill(0.0);
    }

    /// One step of `h` s with the measured angles, NaN where there is none, and the model's accelerations.
    pub(super) fn update(&mut self, h: f64, measured: &[f64], acceleration: &[f64]) {
        for (k, (measured, a)) in measured.iter().zip(acceleration).enumerate() {
            let e = if measured.is_finite() { measured - self.q[k] } else { 0.0 };
            let ratio = (e.abs() / self.innovation_threshold).clamp(1.0, self.max_bandwidth_ratio);
            let w = self.bandwidth * ratio;
            self.q[k] += h * (self.v[k] + 3.0 * w * e);
            self.v[k] += h * (a + self.disturbance[k] + 3.0 * w * w * e);
            self.disturbance[k] += h * w * w * w * e;
        }
    }
}
