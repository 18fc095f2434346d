use super::kinematics::{PoseRows, Poses};
use super::link::{Link, LinkRows};
use super::robot::Robot;
use crate::error::{Error, check_length};
use crate::lanes::{Row, Vector};
use alloc::vec;

/// Mass whose weight is held, and its first moment in the world.
pub(crate) type Held<const N: usize> = (Row<N>, Vector<N>);

impl Robot {
    /// Whether the weight of a body is held.
    pub(crate) fn is_compensated(&self) -> bool {
        self.parts().bodies.iter().any(|body| body.gravity_compensation != 0.0)
    }

    /// Forces of what holds the weight of bodies, MuJoCo's `qfrc_gravcomp`.
    ///
    /// ```text
    /// tau = -sum_b c_b m_b J_b^T g
    /// ```
    ///
    /// | symbol | unit  | meaning                                                              |
    /// |--------|-------|----------------------------------------------------------------------|
    /// | tau    | Nm, N | forces on the joints, as those of springs                            |
    /// | c      |       | fraction of its weight that is held: 1 holds it, more lifts the body |
    /// | m      | kg    | mass of a body                                                       |
    /// | J      |       | Jacobian of its centre of mass                                       |
    /// | g      | m/s^2 | acceleration of gravity                                              |
    ///
    /// # Shapes
    /// `tau: [nv]`.
    ///
    /// # Assumes
    /// The force follows the mass centre whatever the body's motion is, and has no mass of its own.
    ///
    /// # Errors
    /// [`Error::WrongLength`].
    ///
    /// # Source
    /// `mujoco2012`, whose `gravcomp` has this law.
    pub fn gravity_compensation(&self, poses: &Poses, tau: &mut [f64]) -> Result<(), Error> {
        check_length("poses", poses.links.len(), self.tree.links.len())?;
        check_length("tau", tau.len(), self.nv())?;
        let rows = |index: usize| {
            let mut rows = PoseRows::<1>::default();
            rows.axes.set(0, poses.links[index].axes);
            rows.origin.set(0, poses.links[index].origin);
            rows
        };
        let axes = |velocity: usize| {
            let axis = poses.motion_axes[velocity];
            [Vector::all(axis.angular), Vector::all(axis.linear)]
        };
        tau.fill(0.0);
        let mut held = vec![Held::default(); self.tree.links.len()];
        let gravity = Vector::all(self.parts().gravity);
        let tau = tau.as_chunks_mut().0;
        hold(&self.tree.links, &self.tree.rows, gravity, (rows, axes), &mut held, tau);
        Ok(())
    }
}

/// Adds the [forces](Robot::gravity_compensation) in several worlds to those on the joints: `[nv]`; poses
/// of the links and motion axes of the velocities are given, and memory: `[links]`.
#[inline(always)]
pub(crate) fn hold<const N: usize>(
    links: &[Link],
    rows: &[LinkRows<N>],
    gravity: Vector<N>,
    (pose, axes): (impl Fn(usize) -> PoseRows<N>, impl Fn(usize) -> [Vector<N>; 2]),
    held: &mut [Held<N>],
    torque: &mut [[f64; N]],
) {
    for (index, (held, rows)) in held.iter_mut().zip(rows).enumerate() {
        let (pose, (mass, moment)) = (pose(index), rows.held);
        *held = (mass, mass * pose.origin + pose.axes.rotate(moment));
    }
    for (index, link) in links.iter().enumerate().skip(1).rev() {
        let (mass, moment) = held[index];
        let (force, about) = (mass * gravity, moment.cross(gravity));
        let own = link.v..link.v + link.kind.velocities();
        for (torque, k) in torque[own.clone()].iter_mut().zip(own) {
            let [angular, linear] = axes(k);
            *torque = (Row(*torque) - (angular.dot(about) + linear.dot(force))).0;
        }
        let parent = &mut held[link.parent];
        *parent = (parent.0 + mass, parent.1 + moment);
    }
}
