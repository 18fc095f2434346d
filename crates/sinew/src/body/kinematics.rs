use super::link::{Link, LinkFrame, LinkRows};
use super::parts::JointKind;
use super::robot::Robot;
use super::vector::{Frame, IDENTITY, Vector, add, compose, cross, frame_of, rotate, unit_quaternion};
use super::vector::{quaternion_of, quaternion_of_axes, sub, unrotate};
use crate::error::{Error, check_length};
use crate::lanes::{self, Row};
use alloc::vec;
use alloc::vec::Vec;

/// Pose of a frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Its axes x, y, z in the world.
    pub axes: [[f64; 3]; 3],
    /// Its origin in the world, m.
    pub origin: [f64; 3],
}

impl Pose {
    const WORLD: Pose = Pose { axes: IDENTITY, origin: [0.0; 3] };

    /// A point of this frame, in the world.
    #[inline]
    #[must_use]
    pub fn point(&self, local: [f64; 3]) -> [f64; 3] {
        add(self.origin, rotate(&self.axes, local))
    }

    /// A point of the world, in this frame.
    #[inline]
    #[must_use]
    pub fn local(&self, point: [f64; 3]) -> [f64; 3] {
        unrotate(&self.axes, sub(point, self.origin))
    }

    /// The same with its axes turned about its origin by a rotation vector in the world, rad.
    #[must_use]
    pub fn turned(&self, rotation: [f64; 3]) -> Pose {
        Pose { axes: compose(&frame_of(quaternion_of(rotation)), &self.axes), origin: self.origin }
    }

    /// With this orientation, a quaternion `[w, x, y, z]` of any length but zero, and this origin, m.
    #[must_use]
    pub fn new(quaternion: [f64; 4], origin: [f64; 3]) -> Pose {
        Pose { axes: frame_of(unit_quaternion(quaternion)), origin }
    }

    /// Its orientation as a unit quaternion `[w, x, y, z]`.
    #[must_use]
    pub fn quaternion(&self) -> [f64; 4] {
        quaternion_of_axes(&self.axes)
    }

    /// A frame given in this one, in the world.
    #[inline]
    pub(crate) fn inner(&self, axes: &Frame, origin: Vector) -> Pose {
        Pose { axes: compose(&self.axes, axes), origin: self.point(origin) }
    }
}

/// Motion per unit of one joint velocity as a spatial vector: a point at `x` has the velocity `angular x x +
/// linear`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionAxis {
    /// Angular velocity in the world.
    pub angular: [f64; 3],
    /// Velocity of the body-fixed point at the world's origin.
    pub linear: [f64; 3],
}

impl MotionAxis {
    /// Velocity of a point.
    #[inline]
    #[must_use]
    pub fn at(&self, point: [f64; 3]) -> [f64; 3] {
        add(cross(self.angular, point), self.linear)
    }
}

/// Poses of all links and motion axes of all joints: the result of forward kinematics.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    pub(crate) links: Vec<Pose>,
    pub(crate) motion_axes: Vec<MotionAxis>,
}

impl Poses {
    /// Memory for the poses of a robot; all at the origin.
    #[must_use]
    pub fn new(robot: &Robot) -> Poses {
        Poses {
            links: vec![Pose::WORLD; robot.tree.links.len()],
            motion_axes: vec![MotionAxis::default(); robot.nv()],
        }
    }

    /// Motion axis of every velocity, `[nv]`; it applies to the subtree of its joint.
    #[must_use]
    pub fn motion_axes(&self) -> &[MotionAxis] {
        &self.motion_axes
    }

    #[inline]
    pub(crate) fn of(&self, place: &LinkFrame) -> Pose {
        self.links[place.link].inner(&place.axes, place.origin)
    }

    /// Pose of one link from that of its parent.
    #[inline]
    pub(crate) fn place(&mut self, robot: &Robot, index: usize, q: &[f64]) {
        let (link, rows) = (&robot.tree.links[index], &robot.tree.rows[index]);
        let Pose { axes, origin } = self.links[link.parent];
        let mut parent = PoseRows::default();
        parent.axes.set(0, axes);
        parent.origin.set(0, origin);
        let pose = parent.child(link, rows, q.as_chunks().0);
        self.links[index] = Pose { axes: pose.axes.at(0), origin: pose.origin.at(0) };
        for (k, axis) in self.motion_axes[link.v..link.v + link.kind.velocities()].iter_mut().enumerate() {
            let [angular, linear] = pose.motion_axis(link.kind, k);
            *axis = MotionAxis { angular: angular.at(0), linear: linear.at(0) };
        }
    }
}

/// Pose of a frame in several worlds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PoseRows<const N: usize> {
    pub(crate) axes: lanes::Frame<N>,
    pub(crate) origin: lanes::Vector<N>,
}

impl<const N: usize> PoseRows<N> {
    /// The ground.
    pub(crate) fn world() -> Self {
        let axis = |k: usize| lanes::Vector::all(IDENTITY[k]);
        Self { axes: lanes::Frame([axis(0), axis(1), axis(2)]), origin: lanes::Vector::default() }
    }

    /// A point of this frame, in the world.
    #[inline(always)]
    pub(crate) fn point(&self, local: lanes::Vector<N>) -> lanes::Vector<N> {
        self.origin + self.axes.rotate(local)
    }

    /// A frame given in this one, in the world.
    #[inline(always)]
    pub(crate) fn inner(&self, axes: &lanes::Frame<N>, origin: lanes::Vector<N>) -> Self {
        Self { axes: self.axes.compose(axes), origin: self.point(origin) }
    }

    /// Pose of a link whose parent has this one; `q: [nq]`.
    #[inline(always)]
    pub(crate) fn child(&self, link: &Link, rows: &LinkRows<N>, q: &[[f64; N]]) -> Self {
        let start = self.inner(&rows.axes, rows.origin);
        start.moved(link, rows.reference, q)
    }

    /// A frame moved by the joint of a link from where it is at its reference.
    #[inline(always)]
    pub(super) fn moved(self, link: &Link, reference: Row<N>, q: &[[f64; N]]) -> Self {
        let Self { axes, origin } = self;
        match link.kind {
            JointKind::Hinge => {
                Self { axes: axes.turn_about_z((Row(q[link.q]) - reference).sincos()), origin }
            }
            JointKind::Slide => Self { axes, origin: origin + (Row(q[link.q]) - reference) * axes.0[2] },
            JointKind::Ball => Self { axes: axes.compose(&orientation(&q[link.q..])), origin },
            JointKind::Free => Self {
                axes: orientation(&q[link.q + 3..]),
                origin: lanes::Vector([Row(q[link.q]), Row(q[link.q + 1]), Row(q[link.q + 2])]),
            },
        }
    }

    /// Motion axis of the `k`th velocity of a link with this pose: angular, and linear at the world's origin.
    #[inline(always)]
    pub(crate) fn motion_axis(&self, kind: JointKind, k: usize) -> [lanes::Vector<N>; 2] {
        let about = |axis: usize| [self.axes.0[axis], self.origin.cross(self.axes.0[axis])];
        match kind {
            JointKind::Hinge => about(2),
            JointKind::Slide => [lanes::Vector::default(), self.axes.0[2]],
            JointKind::Ball => about(k),
            JointKind::Free if k < 3 => [lanes::Vector::default(), lanes::Vector::all(IDENTITY[k])],
            JointKind::Free => about(k - 3),
        }
    }
}

/// The axes of the quaternion that `q` begins with, normalised.
#[inline(always)]
fn orientation<const N: usize>(q: &[[f64; N]]) -> lanes::Frame<N> {
    let mut axes = lanes::Frame::default();
    (0..N).for_each(|k| axes.set(k, frame_of(unit_quaternion([q[0][k], q[1][k], q[2][k], q[3][k]]))));
    axes
}

impl Robot {
    /// Poses of all bodies.
    ///
    /// # Shapes
    /// `q: [nq]`; quaternions in it may have any length but zero.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    #[doc(alias = "fk")]
    pub fn forward_kinematics(&self, q: &[f64], poses: &mut Poses) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_poses(poses)?;
        (1..self.tree.links.len()).for_each(|index| poses.place(self, index, q));
        Ok(())
    }

    /// The pose of a body; the world's for an index out of range.
    #[must_use]
    pub fn body_pose(&self, poses: &Poses, body: usize) -> Pose {
        self.tree.bodies.get(body).map_or(Pose::WORLD, |place| poses.of(place))
    }

    /// The pose of a site; the world's for an index out of range.
    #[must_use]
    pub fn site_pose(&self, poses: &Poses, site: usize) -> Pose {
        if site < self.parts().sites.len() { poses.of(&self.site_place(site)) } else { Pose::WORLD }
    }

    /// Jacobian of a point fixed to `body`.
    ///
    /// ```text
    /// x' = J v,    omega = J_omega v
    /// ```
    ///
    /// # Shapes
    /// `point` in the world; `linear` and `angular`: `[3 x nv]`, row by row.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice; a `body` out of range is [`Error::OutOfDomain`].
    pub fn jacobian(
        &self,
        poses: &Poses,
        body: usize,
        point: [f64; 3],
        linear: &mut [f64],
        angular: &mut [f64],
    ) -> Result<(), Error> {
        let nv = self.nv();
        self.check_poses(poses)?;
        check_length("linear", linear.len(), 3 * nv)?;
        check_length("angular", angular.len(), 3 * nv)?;
        let Some(place) = self.tree.bodies.get(body) else {
            return Err(Error::OutOfDomain {
                name: "body",
                expected: "an index of a body",
                got: body as f64,
            });
        };
        linear.fill(0.0);
        angular.fill(0.0);
        let mut at = place.link;
        while at != 0 {
            let link = &self.tree.links[at];
            for v in link.v..link.v + link.kind.velocities() {
                let axis = &poses.motion_axes[v];
                for (row, (x, w)) in axis.at(point).into_iter().zip(axis.angular).enumerate() {
                    linear[row * nv + v] = x;
                    angular[row * nv + v] = w;
                }
            }
            at = link.parent;
        }
        Ok(())
    }

    fn check_poses(&self, poses: &Poses) -> Result<(), Error> {
        check_length("poses", poses.links.len(), self.tree.links.len())?;
        check_length("poses", poses.motion_axes.len(), self.nv())
    }
}
