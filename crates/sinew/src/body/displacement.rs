//! Joints whose frames are not where their description has them, and links that bend.

use super::kinematics::Poses;
use super::link::Inertia;
use super::parts::{JointKind, Parts, Wrap, WrapKind};
use super::robot::Robot;
use super::vector::{
    Frame, IDENTITY, Vector, add, add_scaled, compose, cross, frame_about, frame_of, quaternion_of,
    quaternion_of_axes, rotate, scale, sub, transpose,
};
use crate::error::Error;
use alloc::vec;

/// Displacement of the frame of a joint, with all that it carries, from where the description has it.
///
/// ```text
/// T = Trans(p + d) Rot(t) Rot(axis, q)
/// ```
///
/// The frame has the joint's axis as z; its x is the direction nearest to the body's axis that is most
/// across.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Displacement {
    /// `d`, m.
    pub offset: [f64; 3],
    /// `t`, a rotation vector about x and y, rad.
    pub tilt: [f64; 2],
}

/// How a joint differs from its description, by a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointCorrection {
    /// Of its frame.
    pub displacement: Displacement,
    /// Reading of its encoder where the description has its coordinate at zero, rad or m.
    pub zero: f64,
    /// Bend of the link behind it, rad/Nm.
    pub flex: f64,
}

/// A rigid transform: axes of a frame, and its origin.
type Rigid = (Frame, Vector);

fn after(outer: &Rigid, inner: &Rigid) -> Rigid {
    (compose(&outer.0, &inner.0), add(outer.1, rotate(&outer.0, inner.1)))
}

fn inverse((axes, origin): &Rigid) -> Rigid {
    let axes = transpose(axes);
    (axes, scale(-1.0, rotate(&axes, *origin)))
}

/// m, and the sine of an angle: rounding of a description, within which a pulley is on a shaft.
const ON_SHAFT: f64 = 1e-5;

impl Wrap {
    /// Whether it turns about the z axis of a frame in its body.
    fn is_on(&self, shaft: &Rigid) -> bool {
        let (axes, [x, y, _]) = after(&inverse(shaft), &(frame_of(self.orientation), self.position));
        let [across, beside, _] = axes[2];
        let aligned = self.kind == WrapKind::Sphere || libm::hypot(across, beside) < ON_SHAFT;
        aligned && libm::hypot(x, y) < ON_SHAFT
    }
}

impl Parts {
    /// The same in the readings of its encoders as coordinates: `corrections: [joints]`. Ranges of the
    /// joints stay
    /// where they are in space.
    #[must_use]
    pub fn corrected(&self, corrections: &[JointCorrection]) -> Parts {
        let displacements: vec::Vec<Displacement> = corrections.iter().map(|at| at.displacement).collect();
        let mut parts = self.displaced(&displacements);
        for (joint, JointCorrection { zero, flex, .. }) in parts.joints.iter_mut().zip(corrections) {
            joint.reference += zero;
            joint.spring_reference += zero;
            joint.range = joint.range.map(|range| range.map(|end| end + zero));
            joint.flex += flex;
        }
        parts
    }

    /// The same with displaced joints: `[joints]`. Bodies, anchors and axes move. What is fixed to a body
    /// stays where it is on it, but for a pulley on the axis of the first joint of the next body: it is
    /// turned about that axis and sits on the same shaft. Without a displacement the result is
    /// bit-identical; free joints have none.
    ///
    /// ```text
    /// prod_i A_i D_i R_i A_i^-1 = prod_i (A'_i R_i A'_i^-1) E_n,    E_i = E_(i-1) A_i D_i A_i^-1,    A'_i = E_(i-1) A_i D_i
    /// ```
    #[must_use]
    pub fn displaced(&self, displacements: &[Displacement]) -> Parts {
        let mut parts = self.clone();
        let mut next = 0;
        for (index, body) in parts.bodies.iter_mut().enumerate() {
            let first = next;
            while self.joints.get(next).is_some_and(|joint| joint.body == index) {
                next += 1;
            }
            let still = |joint: usize| {
                self.joints[joint].kind == JointKind::Free
                    || displacements.get(joint).is_none_or(|at| *at == Displacement::default())
            };
            if (first..next).all(still) {
                continue;
            }
            let mut moved: Rigid = (IDENTITY, [0.0; 3]);
            let mut frames = vec![];
            let placed = (frame_of(body.orientation), body.position);
            for joint in first..next {
                let part = &self.joints[joint];
                let Displacement { offset, tilt: [x, y] } =
                    displacements.get(joint).copied().unwrap_or_default();
                let own = (frame_about(part.axis), part.anchor);
                let displaced = after(&own, &(frame_of(quaternion_of([x, y, 0.0])), offset));
                let frame = after(&moved, &displaced);
                moved = after(&frame, &inverse(&own));
                frames.push(frame);
                if joint == first && part.kind == JointKind::Hinge {
                    let shaft = after(&placed, &own);
                    let moves = after(&after(&placed, &moved), &inverse(&placed));
                    let on_parent = parts.wraps.iter_mut().filter(|wrap| wrap.body == body.parent);
                    for wrap in on_parent.filter(|wrap| wrap.is_on(&shaft)) {
                        let at = after(&moves, &(frame_of(wrap.orientation), wrap.position));
                        (wrap.orientation, wrap.position) = (quaternion_of_axes(&at.0), at.1);
                    }
                }
            }
            let back = inverse(&moved);
            for (joint, frame) in parts.joints[first..next].iter_mut().zip(&frames) {
                let (axes, anchor) = after(&back, frame);
                (joint.axis, joint.anchor) = (axes[2], anchor);
            }
            let (axes, position) = after(&placed, &moved);
            (body.orientation, body.position) = (quaternion_of_axes(&axes), position);
        }
        parts
    }
}

impl Robot {
    /// Poses of all bodies where the moment of gravity bends the links at their joints, in equilibrium; the
    /// motion axes are those before the bending.
    ///
    /// ```text
    /// T_i = A_i Rot(kappa_i m_i) Rot(axis_i, q_i),    m_i: moment of gravity about joint i of what it carries
    /// ```
    ///
    /// Where no joint has a flex, `kappa`, this is [`forward_kinematics`](Self::forward_kinematics) to
    /// the bit.
    ///
    /// # Assumes
    /// Small angles: the moments are those of the rigid robot.
    ///
    /// # Errors
    /// As [`forward_kinematics`](Self::forward_kinematics).
    pub fn bent_kinematics(&self, q: &[f64], poses: &mut Poses) -> Result<(), Error> {
        self.forward_kinematics(q, poses)?;
        let joints = &self.parts().joints;
        if joints.iter().all(|joint| joint.flex == 0.0) {
            return Ok(());
        }
        let links = &self.tree.links;
        // Weight of each subtree, and its first moment about the world's origin.
        let mut carried = vec![Inertia::default(); links.len()];
        for (index, link) in links.iter().enumerate().skip(1).rev() {
            let pose = &poses.links[index];
            let (mass, moment) = link.weighing();
            let own = add_scaled(rotate(&pose.axes, moment), mass, pose.origin);
            let sum = &mut carried[index];
            (sum.mass, sum.moment) = (sum.mass + mass, add(sum.moment, own));
            let Inertia { mass, moment, .. } = carried[index];
            let parent = &mut carried[link.parent];
            (parent.mass, parent.moment) = (parent.mass + mass, add(parent.moment, moment));
        }
        for (index, link) in links.iter().enumerate().skip(1) {
            let Inertia { mass, moment, .. } = carried[index];
            let about = sub(moment, scale(mass, poses.links[index].origin));
            // The origin of the rigid pose is overwritten only now.
            let bend = scale(joints[link.joint].flex, cross(about, self.parts().gravity));
            poses.place(self, index, q);
            let pose = &mut poses.links[index];
            pose.axes = compose(&frame_of(quaternion_of(bend)), &pose.axes);
        }
        Ok(())
    }
}
