use crate::control::arm::ArmGains;
use crate::control::arm::JointGains;
use crate::control::stretch::PREVIEW_HORIZON;
use crate::trajectory::Reference;

/// The reference of a pose that is kept: it begins where a motion was left and comes to rest.
///
/// ```text
/// q'_h' = -clip(q'_h/h, +-a_h),   q_h' = q'_h,   a_h = w e_q / 1 s
/// q_h(t + t_p) = q_h + q'_h t_b - sign(q'_h) a_h t_b^2/2,   t_b = min(t_p, |q'_h|/a_h)      previewed
/// ```
///
/// | symbol | meaning                                            | unit        |
/// |--------|----------------------------------------------------|-------------|
/// | q_h    | held pose                                          | rad         |
/// | w, e_q | bandwidth and largest error of the joint's controller | rad/s, rad |
/// | t_p    | [`PREVIEW_HORIZON`]: without a preview the winches would begin to brake too late, and cables fall slack | s |
#[derive(Debug, Clone)]
pub(super) struct HeldReference {
    /// Of the joints.
    pub(super) reference: Reference,
    /// The same after the preview horizon.
    pub(super) previewed: Reference,
}

/// Fraction of a joint's largest error within which a reference is near the held pose, 1.
const NEAR: f64 = 0.2;

impl HeldReference {
    pub(super) fn new(joints: usize) -> Self {
        Self { reference: Reference::new(joints), previewed: Reference::new(joints) }
    }

    /// At rest in a measured pose, rad or m; a coordinate that is not measured is that of the given
    /// reference.
    pub(super) fn rest_at(&mut self, measured: &[f64], given: &Reference) {
        let coordinates = measured.iter().zip(&given.q);
        for (held, (measured, given)) in self.reference.q.iter_mut().zip(coordinates) {
            *held = if measured.is_finite() { *measured } else { *given };
        }
        self.reference.v.fill(0.0);
        self.reference.a.fill(0.0);
    }

    /// Takes a reference that is followed.
    pub(super) fn follow(&mut self, followed: &Reference) {
        self.reference.q.copy_from_slice(&followed.q);
        self.reference.v.copy_from_slice(&followed.v);
        self.reference.a.copy_from_slice(&followed.a);
    }

    /// `h` s on.
    pub(super) fn step(&mut self, h: f64, gains: &ArmGains) {
        let Reference { q, v, a, .. } = &mut self.reference;
        for (((q, v), a), gains) in q.iter_mut().zip(v).zip(a).zip(&gains.joints) {
            let most = deceleration(gains);
            *a = (-*v / h).clamp(-most, most);
            *v += h * *a;
            *q += h * *v;
        }
    }

    /// Where it will be after the preview horizon.
    pub(super) fn preview(&mut self, gains: &ArmGains) {
        let Self { reference, previewed } = self;
        for (k, gains) in gains.joints.iter().enumerate() {
            let (v, most) = (reference.v[k], deceleration(gains).copysign(reference.v[k]));
            let braking = PREVIEW_HORIZON.min(v.abs() / most.abs());
            let left = v - most * braking;
            previewed.q[k] = reference.q[k] + v * braking - 0.5 * most * braking * braking;
            previewed.v[k] = left;
            previewed.a[k] = if left.abs() > 0.0 { -most } else { 0.0 };
        }
    }

    /// Whether a reference is near the held pose in every joint.
    pub(super) fn is_near(&self, given: &Reference, gains: &ArmGains) -> bool {
        let coordinates = self.reference.q.iter().zip(&given.q);
        coordinates
            .zip(&gains.joints)
            .all(|((held, given), gains)| (held - given).abs() <= NEAR * gains.tracking_error)
    }
}

/// `a_h`.
fn deceleration(gains: &JointGains) -> f64 {
    gains.bandwidth * gains.tracking_error
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// Gains with `a_h` of 2 rad/s^2 and errors of at most 0.5 rad.
    fn gains() -> ArmGains {
        let mut gains = ArmGains::for_tests(1, 2);
        gains.joints.iter_mut().for_each(|joint| (joint.bandwidth, joint.tracking_error) = (4.0, 0.5));
        gains
    }

    fn moving(v: [f64; 2]) -> HeldReference {
        let mut held = HeldReference::new(2);
        held.follow(&Reference { q: vec![0.3, -0.2], v: v.to_vec(), a: vec![7.0, -7.0] });
        held
    }

    #[test]
    fn a_held_pose_is_at_rest_where_it_is_measured_and_where_it_is_not_in_the_given_one() {
        let mut held = moving([1.0, -1.0]);
        held.rest_at(&[0.1, f64::NAN], &Reference { q: vec![5.0, 0.7], v: vec![3.0; 2], a: vec![3.0; 2] });
        assert_eq!(held.reference, Reference { q: vec![0.1, 0.7], ..Reference::new(2) });
    }

    #[test]
    fn a_motion_that_is_left_comes_to_rest_at_the_deceleration_of_the_controller() {
        let gains = gains();
        let mut held = moving([0.8, -0.4]);
        assert_eq!(held.reference.v, [0.8, -0.4], "it begins with the speed of the motion");
        for cycle in 1..=600_u32 {
            held.step(1e-3, &gains);
            let braked = 2e-3 * f64::from(cycle);
            let expected = [(0.8 - braked).max(0.0), (braked - 0.4).min(0.0)];
            for (v, expected) in held.reference.v.iter().zip(expected) {
                assert!((v - expected).abs() < 1e-9, "{cycle}: {v} {expected}");
            }
            assert!(held.reference.a[0] <= 0.0 && held.reference.a[1] >= 0.0);
        }
        // v^2/(2 a_h), but for half a cycle.
        for (q, [from, way]) in held.reference.q.iter().zip([[0.3, 0.16], [-0.2, -0.04]]) {
            assert!((q - from - way).abs() < 5e-4, "{q}");
        }
        assert!(held.reference.v.iter().chain(&held.reference.a).all(|rate| rate.abs() < 1e-9));
    }

    #[test]
    fn what_is_previewed_is_where_the_held_pose_will_be() {
        let gains = gains();
        // The second joint comes to rest within the horizon of 0.12 s, the third motion is at rest.
        for v in [[0.8, -0.15], [-0.6, 0.1], [0.0, 0.24]] {
            let mut held = moving(v);
            held.preview(&gains);
            let seen = held.previewed.clone();
            for _ in 0..12_000 {
                held.step(PREVIEW_HORIZON / 12_000.0, &gains);
            }
            for k in 0..2 {
                let (q, v) = (held.reference.q[k], held.reference.v[k]);
                assert!((seen.q[k] - q).abs() < 1e-5 && (seen.v[k] - v).abs() < 1e-5, "{seen:?} {held:?}");
                let braking = if v.abs() > 1e-9 { -2.0 * v.signum() } else { 0.0 };
                assert!((seen.a[k] - braking).abs() < 1e-9, "{seen:?}");
            }
        }
    }

    #[test]
    fn a_reference_is_near_within_a_fifth_of_the_largest_error_of_every_joint() {
        let (held, gains) = (moving([0.0; 2]), gains());
        let near = |off: [f64; 2]| {
            let q = vec![0.3 + off[0], -0.2 + off[1]];
            held.is_near(&Reference { q, ..Reference::new(2) }, &gains)
        };
        assert!(near([0.099, -0.099]) && near([-0.099, 0.0]));
        for off in [[0.101, 0.0], [0.0, 0.101], [-0.101, 0.0], [0.0, -0.101], [0.5, 0.5]] {
            assert!(!near(off), "{off:?}");
        }
    }
}
