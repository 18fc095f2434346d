//! Serial chains by their modified Denavit-Hartenberg table.

use super::parts::{Body, Joint, JointKind, Parts};
use super::robot::Robot;
use super::vector::quaternion_of_axes;
use super::vector::{
    Frame, IDENTITY, Vector, add_scaled, cross, dot, norm, quaternion_of, quaternion_product, rotate, scale,
    sub, transpose,
};
use crate::error::Error;
use alloc::string::ToString;
use alloc::vec::Vec;
use alloc::{format, vec};

/// One joint of a chain in Craig's convention.
///
/// ```text
/// T(i-1, i) = RotX(alpha) TransX(a) RotZ(theta) TransZ(d)
/// ```
///
/// A hinge adds its coordinate to `theta`, a slide to `d`.
///
/// # Source
/// `craig2005`, section 3.6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DhRow {
    /// Twist about the previous x, rad.
    pub alpha: f64,
    /// Translation along the previous x, m.
    pub a: f64,
    /// Translation along z, m.
    pub d: f64,
    /// Rotation about z, rad.
    pub theta: f64,
    /// Hinge or slide.
    pub kind: JointKind,
}

/// A chain: pose of frame 0, joints, and end point in the last frame.
#[derive(Debug, Clone, PartialEq)]
pub struct DhTable {
    /// Axes of frame 0 in the world, as columns.
    pub base_axes: [[f64; 3]; 3],
    /// Origin of frame 0 in the world, m.
    pub base_origin: [f64; 3],
    /// The joints from the base on.
    pub rows: Vec<DhRow>,
    /// The end point in the last frame, m.
    pub end: [f64; 3],
}

/// Norm of the cross product below which directions count as parallel.
const PARALLEL: f64 = 1e-9;

impl DhTable {
    /// A robot of massless links `link1`, `link2`... with joints `joint1`..., and the site `end`.
    #[must_use]
    pub fn parts(&self) -> Parts {
        let none = Body {
            name: "world".to_string(),
            parent: 0,
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            mass: 0.0,
            center_of_mass: [0.0; 3],
            inertia: [0.0; 6],
        };
        let base = Body {
            name: "base".to_string(),
            position: self.base_origin,
            orientation: quaternion_of_axes(&self.base_axes),
            ..none.clone()
        };
        let (mut bodies, mut joints) = (vec![none.clone(), base], Vec::new());
        for (k, row) in self.rows.iter().enumerate() {
            let twist = quaternion_of([row.alpha, 0.0, 0.0]);
            let orientation = quaternion_product(twist, quaternion_of([0.0, 0.0, row.theta]));
            let position = [row.a, -row.d * libm::sin(row.alpha), row.d * libm::cos(row.alpha)];
            let name = format!("link{}", k + 1);
            bodies.push(Body { name, parent: k + 1, position, orientation, ..none.clone() });
            joints.push(Joint {
                name: format!("joint{}", k + 1),
                body: k + 2,
                kind: row.kind,
                anchor: [0.0; 3],
                axis: IDENTITY[2],
                reference: 0.0,
                range: None,
                armature: 0.0,
                damping: 0.0,
                friction: 0.0,
                stiffness: 0.0,
                spring_reference: 0.0,
            });
        }
        let end = super::parts::Site {
            name: "end".to_string(),
            body: self.rows.len() + 1,
            position: self.end,
            orientation: [1.0, 0.0, 0.0, 0.0],
        };
        Parts { bodies, joints, sites: vec![end], gravity: [0.0, 0.0, -9.81], ..Parts::default() }
    }
}

impl Robot {
    /// The table of the hinges and slides from the world to a site, which is the chain's end.
    ///
    /// Parallel and intersecting axes leave a choice: `d = 0` for parallel axes; where two axes intersect, x
    /// is along their cross product.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a site out of range, [`Error::Part`] for a joint of the chain with more
    /// than one coordinate.
    pub fn dh_table(&self, site: usize) -> Result<DhTable, Error> {
        let Some(part) = self.parts().sites.get(site) else {
            return Err(Error::OutOfDomain {
                name: "site",
                expected: "an index of a site",
                got: site as f64,
            });
        };
        let mut poses = super::Poses::new(self);
        self.forward_kinematics(&self.reference_pose(), &mut poses)?;
        let (mut at, mut chain) = (self.tree.bodies[part.body].link, Vec::new());
        while at != 0 {
            let link = &self.tree.links[at];
            if link.kind.velocities() != 1 {
                let expected = "a hinge or a slide";
                return Err(Error::Part { kind: "joint", index: link.joint, field: "its kind", expected });
            }
            chain.push((poses.links[at].axes[2], poses.links[at].origin, link.kind, link.reference));
            at = link.parent;
        }
        chain.reverse();
        let end = self.site_pose(&poses, site).origin;
        Ok(table(&chain, end))
    }
}

/// Axis, a point on it, kind and reference of each joint in the world, to a table.
fn table(chain: &[(Vector, Vector, JointKind, f64)], end: Vector) -> DhTable {
    let Some(&(first, origin, ..)) = chain.first() else {
        return DhTable { base_axes: IDENTITY, base_origin: [0.0; 3], rows: Vec::new(), end };
    };
    // Frame 0 is frame 1 at zero; x as the first common normal has it.
    let (x, foot) = normal(first, origin, chain.get(1), end);
    let mut frame: Frame = [x, cross(first, x), first];
    let mut place = foot;
    let (base_axes, base_origin) = (frame, place);
    let mut rows = Vec::new();
    for (k, &(axis, point, kind, reference)) in chain.iter().enumerate() {
        let along = frame[0];
        let alpha = libm::atan2(dot(cross(frame[2], axis), along), dot(frame[2], axis));
        let a = dot(sub(point, place), along);
        let start = add_scaled(place, a, along);
        let (x, foot) = if k == 0 { (frame[0], place) } else { normal(axis, point, chain.get(k + 1), end) };
        let d = dot(sub(foot, start), axis);
        let theta = libm::atan2(dot(cross(along, x), axis), dot(along, x));
        let (d, theta) = match kind {
            JointKind::Slide => (d - reference, theta),
            _ => (d, theta - reference),
        };
        rows.push(DhRow { alpha, a, d, theta, kind });
        frame = [x, cross(axis, x), axis];
        place = foot;
    }
    let end = rotate(&transpose(&frame), sub(end, place));
    DhTable { base_axes, base_origin, rows, end }
}

/// Direction of the common normal from one axis to the next and where it starts; towards the end for the
/// last.
fn normal(
    axis: Vector,
    point: Vector,
    next: Option<&(Vector, Vector, JointKind, f64)>,
    end: Vector,
) -> (Vector, Vector) {
    let (other, place) = next.map_or((axis, end), |&(other, place, ..)| (other, place));
    let between = sub(place, point);
    let across = cross(axis, other);
    let size = norm(across);
    if size > PARALLEL {
        // Foot of the common normal on this axis.
        let distance = dot(cross(between, other), across) / (size * size);
        let foot = add_scaled(point, distance, axis);
        let gap = dot(between, across) / size;
        let sign = if gap < -PARALLEL { -1.0 } else { 1.0 };
        return (scale(sign / size, across), foot);
    }
    let sideways = add_scaled(between, -dot(between, axis), axis);
    let size = norm(sideways);
    if size > PARALLEL {
        return (scale(1.0 / size, sideways), point);
    }
    (super::vector::frame_about(axis)[0], point)
}

#[cfg(test)]
mod tests {
    use super::super::vector::{compose, frame_of};
    use super::*;

    #[test]
    fn a_quaternion_of_axes_gives_the_axes_back() {
        for k in 0..200 {
            let t = f64::from(k);
            let q = super::super::vector::unit_quaternion([
                libm::cos(t),
                libm::sin(1.7 * t),
                libm::cos(2.3 * t),
                libm::sin(3.1 * t),
            ]);
            let axes = frame_of(q);
            let back = frame_of(quaternion_of_axes(&axes));
            let turned = compose(&transpose(&axes), &back);
            for (column, unit) in turned.iter().zip(IDENTITY) {
                assert!(norm(sub(*column, unit)) < 1e-14);
            }
        }
    }

    #[test]
    fn half_turns_have_their_quaternions() {
        for k in 0..3 {
            let mut q = [0.0; 4];
            q[k + 1] = 1.0;
            let back = quaternion_of_axes(&frame_of(q));
            let along = q.iter().zip(back).map(|(a, b)| a * b).sum::<f64>();
            assert!((along.abs() - 1.0).abs() < 1e-15, "{k}: {back:?}");
        }
    }
}
