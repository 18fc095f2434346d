use super::joint_observer::JointObserver;
use super::signals::PreviewedReference;
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Motion of the anchors along their cables, + toward the motor, mapped from the joints by (20): `[muscles]`
/// each.
#[derive(Debug, Clone)]
pub(super) struct AnchorMotion {
    /// `v_r(t) = R q'_r(t)`, m/s.
    pub(super) reference: Vec<f64>,
    /// `v_r(t + t_p)`, m/s.
    pub(super) previewed: Vec<f64>,
    /// `v^ = R q'^`, m/s.
    pub(super) estimated: Vec<f64>,
    /// `v_s`, low pass of `v^`, m/s.
    pub(super) slip: Vec<f64>,
    /// `d = R (q_r - q^)`, m.
    pub(super) error: Vec<f64>,
}

impl AnchorMotion {
    pub(super) fn new(muscles: usize) -> Self {
        Self {
            reference: vec![0.0; muscles],
            previewed: vec![0.0; muscles],
            estimated: vec![0.0; muscles],
            slip: vec![0.0; muscles],
            error: vec![0.0; muscles],
        }
    }

    /// Maps references, estimates and the error of the joints, rad, in the evaluated pose of the body; the
    /// filter of slip advances by `filter_fraction` of its input.
    pub(super) fn update(
        &mut self,
        body: &MuscleDynamics,
        reference: &PreviewedReference<'_>,
        joints: &JointObserver,
        error: &[f64],
        filter_fraction: f64,
    ) {
        body.anchor_motion(&reference.current.v, &mut self.reference);
        body.anchor_motion(&reference.previewed.v, &mut self.previewed);
        body.anchor_motion(&joints.v, &mut self.estimated);
        body.anchor_motion(error, &mut self.error);
        for (slip, estimated) in self.slip.iter_mut().zip(&self.estimated) {
            *slip += filter_fraction * (estimated - *slip);
        }
    }

    /// Whether the position error of every anchor is below a limit, m, and its speed below another, m/s.
    pub(super) fn is_near(&self, limits: impl Iterator<Item = [f64; 2]>) -> bool {
        let anchors = self.error.iter().zip(&self.estimated);
        anchors.zip(limits).all(|((d, v), [error, speed])| d.abs() < error && v.abs() < speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::arm::gains::ArmGains;
    use crate::predictor::CableModel;
    use crate::trajectory::Reference;

    /// `R u` by the dense matrix.
    fn mapped(body: &MuscleDynamics, u: &[f64]) -> Vec<f64> {
        let rows = body.moment_arms().chunks_exact(u.len());
        rows.map(|row| row.iter().zip(u).map(|(arm, u)| arm * u).sum()).collect()
    }

    fn differ(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
    }

    #[test]
    fn references_estimates_and_errors_are_mapped_by_the_moment_arms_and_slip_follows_by_a_low_pass() {
        let mut body = MuscleDynamics::new(&crate::muscle::tests::robots::chain(false)).unwrap();
        body.evaluate(&[0.1, -0.2, 0.3]).unwrap();
        let mut joints =
            JointObserver::new(&vec![CableModel::bench(); 3], &ArmGains::for_tests(3, 3)).unwrap();
        joints.v.copy_from_slice(&[0.5, -0.4, 0.9]);
        let of = |v: [f64; 3]| Reference { v: v.to_vec(), ..Reference::new(3) };
        let (current, previewed, error) = (of([0.3, 0.2, -0.1]), of([-0.6, 0.7, 0.8]), [0.01, -0.02, 0.03]);
        let reference = PreviewedReference { current: &current, previewed: &previewed, repeat_time: None };
        let mut motion = AnchorMotion::new(3);
        let fraction = 0.2;
        for step in 1..=10 {
            motion.update(&body, &reference, &joints, &error, fraction);
            // A step of the input: what is missing shrinks by the same factor in every cycle.
            let reached = 1.0 - libm::pow(1.0 - fraction, f64::from(step));
            let slip: Vec<f64> = mapped(&body, &joints.v).iter().map(|v| reached * v).collect();
            assert!(differ(&motion.slip, &slip) < 1e-15, "{step}: {:?} {slip:?}", motion.slip);
        }
        for (found, u) in [
            (&motion.reference, &current.v[..]),
            (&motion.previewed, &previewed.v),
            (&motion.estimated, &joints.v),
            (&motion.error, &error),
        ] {
            let expected = mapped(&body, u);
            assert!(
                differ(found, &expected) < 1e-15 && expected.iter().all(|v| v.abs() > 1e-5),
                "{expected:?}"
            );
        }
    }

    #[test]
    fn anchors_are_near_while_every_error_and_every_speed_is_below_its_limit() {
        let mut motion = AnchorMotion::new(2);
        let near = |motion: &AnchorMotion| motion.is_near([[0.5, 2.0], [0.25, 1.0]].into_iter());
        for side in [1.0, -1.0] {
            motion.error.copy_from_slice(&[0.4 * side, 0.2]);
            motion.estimated.copy_from_slice(&[1.5, -0.9 * side]);
            assert!(near(&motion));
            for (k, limits) in [[0.5, 2.0], [0.25, 1.0]].into_iter().enumerate() {
                let (mut far, mut fast) = (motion.clone(), motion.clone());
                (far.error[k], fast.estimated[k]) = (side * limits[0], side * limits[1]);
                assert!(!near(&far) && !near(&fast), "at the limit: {k}");
                (far.error[k], fast.estimated[k]) = (1.1 * side * limits[0], 1.1 * side * limits[1]);
                assert!(!near(&far) && !near(&fast), "beyond the limit: {k}");
            }
        }
    }
}
