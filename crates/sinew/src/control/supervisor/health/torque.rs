/// Force that a cable lacks at its anchor, from the torques of the joints' disturbances, over one window.
///
/// ```text
/// f_k = sum_t R_k . tau_d / sum_t R_k . R_k        least squares for one muscle alone
/// E_k = f_k^2 mean |R_k|^2                         what it explains of the torques' mean square
/// ```
///
/// | symbol | meaning                                               | unit   |
/// |--------|-------------------------------------------------------|--------|
/// | R_k    | moment arms of the muscle                             | m      |
/// | tau_d  | torque of the disturbances, `M d^`                    | Nm     |
/// | f_k    | force in addition to the model's                      | N      |
///
/// # Assumes
/// One muscle changes. Errors of masses and friction recur with the same motion: only the change of `f_k` counts. A payload
/// that changes looks the same.
///
/// # Source
/// Our own: a residual of the torque balance (23), as in `chow1984`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TorqueFit {
    right: f64,
    normal: f64,
    count: f64,
}

impl TorqueFit {
    /// One sample: moment arms and torques of all joints.
    pub(super) fn add(&mut self, arms: &[f64], torque: &[f64]) {
        for (arm, torque) in arms.iter().zip(torque) {
            self.right += arm * torque;
            self.normal += arm * arm;
        }
        self.count += 1.0;
    }

    /// `f_k`, N, and the mean of `|R_k|^2`, m^2; none without a moment arm.
    pub(super) fn solve(&self) -> Option<[f64; 2]> {
        (self.normal > 0.0).then(|| [self.right / self.normal, self.normal / self.count])
    }
}
