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
    /// filter of slip advances by `filter_share` of its input.
    pub(super) fn update(
        &mut self,
        body: &MuscleDynamics,
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

    /// Whether the position error of every anchor is below a limit, m, and its speed below another, m/s.
    pub(super) fn is_near(&self, limits: impl Iterator<Item = [f64; 2]>) -> bool {
        let anchors = self.error.iter().zip(&self.estimated);
        anchors.zip(limits).all(|((d, v), [error, speed])| d.abs() < error && v.abs() < speed)
    }
}
