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

/// Share of a joint's largest error within which a reference is near the held pose, 1.
const NEAR: f64 = 0.2;

impl HeldReference {
    pub(super) fn new(joints: usize) -> Self {
        Self { reference: Reference::new(joints), previewed: Reference::new(joints) }
    }

    /// At rest in a measured pose, rad or m; a coordinate that is not measured is that of the given reference.
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
