/// Force that a cable lacks at its anchor and friction that it has more, from the torques that the models of
/// the cables do not explain, over one window.
///
/// ```text
/// tau = tau_d - sum_j R_j l_j                       torque that the laws as identified do not explain
/// f_k = sum_t R_k . tau / sum_t R_k . R_k           least squares for one change of one muscle alone
/// a_k = sum_t r_k . tau / sum_t r_k . r_k,   r_k = -s A (T_out - T_0) R_k
/// P_f = mean R_k . R_k,   P_a = mean r_k . r_k      mean square of the torques per unit of f, of a
/// ```
///
/// | symbol | meaning                                               | unit   |
/// |--------|-------------------------------------------------------|--------|
/// | R_k    | moment arms of the muscle                             | m      |
/// | tau_d  | torque of the disturbances, `M d^`                    | Nm     |
/// | l_j    | drag that a cable's observer has learned, [`SlidingModel::learned_drag`](super::sliding::SlidingModel::learned_drag) | N |
/// | T_out, T_0 | tension at the anchor as the observer estimates it, pretension | N |
/// | s, A   | direction of sliding, 0 where the cable does not slide everywhere; friction angle of the model | 1 |
/// | f_k    | force in addition to the model's                      | N      |
/// | a_k    | friction angle in addition to the model's, as a fraction of it | 1 |
///
/// A force that the anchor lacks has one sign, friction that of the motion. Of all changes of all muscles the
/// true one explains most: with `tau = r_k a`, a wrong one explains
/// `a^2 (sum r_j . r_k)^2/sum r_j . r_j <= a^2 sum r_k . r_k`.
///
/// # Assumes
/// One muscle changes. Errors of masses and friction recur with the same motion: only the changes of `f_k`
/// and `a_k` count. A payload that changes looks the same.
///
/// # Source
/// Our own: a residual of the torque balance (23), as in `chow1984`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TorqueFit {
    force: Projection,
    friction: Projection,
    count: f64,
}

/// Least squares with one unknown.
#[derive(Debug, Clone, Copy, Default)]
struct Projection {
    right: f64,
    normal: f64,
}

/// What is fitted, and the mean square of the torques per its square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fitted {
    pub(super) value: f64,
    pub(super) power: f64,
}

impl TorqueFit {
    /// One sample: moment arms and torques of all joints, and the force at the anchor that the model's
    /// friction angle takes, `s A (T_out - T_0)`.
    pub(super) fn add(&mut self, arms: &[f64], torque: &[f64], friction: f64) {
        let (right, normal) = arms
            .iter()
            .zip(torque)
            .fold((0.0, 0.0), |(right, normal), (arm, torque)| (right + arm * torque, normal + arm * arm));
        self.force.right += right;
        self.force.normal += normal;
        self.friction.right -= friction * right;
        self.friction.normal += friction * friction * normal;
        self.count += 1.0;
    }

    /// Number of samples.
    pub(super) fn samples(&self) -> f64 {
        self.count
    }

    /// `f_k` with `P_f`; none without a moment arm.
    pub(super) fn force(&self) -> Option<Fitted> {
        self.force.solve(self.count)
    }

    /// `a_k` with `P_a`; none where the cable never slides.
    pub(super) fn friction(&self) -> Option<Fitted> {
        self.friction.solve(self.count)
    }
}

impl Projection {
    fn solve(&self, count: f64) -> Option<Fitted> {
        (self.normal > 0.0).then(|| Fitted { value: self.right / self.normal, power: self.normal / count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Joints, muscles and samples of a machine at random.
    const JOINTS: usize = 3;
    const MUSCLES: usize = 6;
    const SAMPLES: usize = 600;

    #[test]
    fn of_all_changes_of_all_muscles_the_true_one_explains_the_torques_best() {
        let mut random = Random::new(11);
        for case in 0..200 {
            let worn = case % MUSCLES;
            let rougher = case % 2 == 0;
            let arms: [[f64; JOINTS]; MUSCLES] = core::array::from_fn(|_| {
                core::array::from_fn(
                    |_| if random.unit() < 0.6 { 0.06 * random.unit() - 0.03 } else { 0.001 },
                )
            });
            let phases: [f64; MUSCLES] = core::array::from_fn(|_| 6.0 * random.unit());
            let mut fits = [TorqueFit::default(); MUSCLES];
            for sample in 0..SAMPLES {
                let angle = 0.05 * sample as f64;
                let friction: [f64; MUSCLES] = core::array::from_fn(|k| {
                    libm::sin(angle + phases[k]).signum()
                        * (30.0 + 20.0 * libm::cos(0.7 * angle + 2.0 * phases[k]))
                });
                let force = if rougher { -0.1 * friction[worn] } else { -2.0 };
                let torque = arms[worn].map(|arm| arm * force);
                (0..MUSCLES).for_each(|k| fits[k].add(&arms[k], &torque, friction[k]));
            }
            let explained = |change: Option<Fitted>| change.map_or(0.0, |c| c.value * c.value * c.power);
            let named = (0..MUSCLES)
                .flat_map(|k| [(k, true, fits[k].friction()), (k, false, fits[k].force())])
                .max_by(|(.., one), (.., other)| explained(*one).total_cmp(&explained(*other)));
            let (muscle, friction, change) = named.unwrap();
            assert_eq!((muscle, friction), (worn, rougher), "case {case}");
            let expected = if rougher { 0.1 } else { -2.0 };
            assert!((change.unwrap().value - expected).abs() < 1e-9, "case {case}: {change:?}");
        }
    }

    #[test]
    fn nothing_is_known_of_a_muscle_without_a_moment_arm_or_without_sliding() {
        let mut fit = TorqueFit::default();
        assert_eq!((fit.force(), fit.friction()), (None, None));
        fit.add(&[0.0], &[1.0], 10.0);
        assert_eq!((fit.force(), fit.friction()), (None, None));
        fit.add(&[0.02], &[1.0], 0.0);
        assert!(fit.force().is_some() && fit.friction().is_none());
    }

    #[test]
    fn the_power_is_the_mean_square_of_the_torques_per_unit() {
        let mut fit = TorqueFit::default();
        for (arm, friction) in [(0.02, 10.0), (0.03, -20.0), (0.05, 0.0), (0.04, 5.0)] {
            fit.add(&[arm], &[0.5 * arm], friction);
        }
        let [force, rough] = [fit.force(), fit.friction()].map(|fitted| fitted.unwrap().power);
        assert!((force - (4.0 + 9.0 + 25.0 + 16.0) * 1e-4 / 4.0).abs() < 1e-15);
        assert!((rough - (0.2 * 0.2 + 0.6 * 0.6 + 0.2 * 0.2) / 4.0).abs() < 1e-15);
        assert!((fit.samples() - 4.0).abs() < 1e-15);
    }
}
