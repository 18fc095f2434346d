use super::body_model::BodyModel;
use super::joint_observer::JointObserver;
use super::signals::PreviewedReference;
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
    /// filter of slip advances by `filter_share` of its input.
    pub(super) fn update(
        &mut self,
        body: &BodyModel,
        reference: &PreviewedReference<'_>,
        joints: &JointObserver,
        error: &[f64],
        filter_share: f64,
    ) {
        body.anchor_motion(&reference.current.v, &mut self.reference);
        body.anchor_motion(&reference.previewed.v, &mut self.previewed);
        body.anchor_motion(&joints.v, &mut self.estimated);
        body.anchor_motion(error, &mut self.error);
        for (slip, estimated) in self.slip.iter_mut().zip(&self.estimated) {
            *slip += filter_share * (estimated - *slip);
        }
    }

    /// Largest magnitude of the position errors, m.
    pub(super) fn largest_error(&self) -> f64 {
        self.error.iter().fold(0.0, |largest, d| largest.max(d.abs()))
    }
}
