use super::kinematics::orientation;
use super::parts::JointKind;
use super::robot::{Robot, numbers};
use super::scratch::Scratch;
use super::tree::Link;
use super::vector::{
    Frame, Vector, add, add_scaled, compose, cross, rotate, scale, sub, symmetric, turn_about_z, unrotate,
};
use crate::error::Error;

/// Motion and load of one link, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moving {
    /// Axes in the parent's frame.
    pub(super) axes: Frame,
    /// Origin in the parent's frame.
    pub(super) origin: Vector,
    /// Angular velocity.
    pub(super) omega: Vector,
    /// Velocity of the origin.
    pub(super) velocity: Vector,
    /// Angular acceleration.
    pub(super) alpha: Vector,
    /// Acceleration of the origin, against free fall.
    pub(super) acceleration: Vector,
    /// Force on the link.
    pub(super) force: Vector,
    /// Moment on the link about its origin.
    pub(super) moment: Vector,
}

impl Link {
    /// Axes and origin in the parent's frame.
    #[inline]
    pub(super) fn pose_in_parent(&self, q: &[f64]) -> (Frame, Vector) {
        match self.kind {
            JointKind::Hinge => {
                (turn_about_z(&self.axes, libm::sincos(q[self.q] - self.reference)), self.origin)
            }
            JointKind::Slide => {
                let way = q[self.q] - self.reference;
                (self.axes, add_scaled(self.origin, way, self.axes[2]))
            }
            JointKind::Ball => (compose(&self.axes, &orientation(&q[self.q..])), self.origin),
            JointKind::Free => (orientation(&q[self.q + 3..]), [q[self.q], q[self.q + 1], q[self.q + 2]]),
        }
    }
}

impl Robot {
    /// Generalised forces for a wanted acceleration.
    ///
    /// ```text
    /// tau = M(q) a + c(q, v) + g(q)
    /// ```
    ///
    /// | symbol | argument | unit          | meaning                                        |
    /// |--------|----------|---------------|------------------------------------------------|
    /// | q      | `q`      | rad, m        | coordinates                                    |
    /// | v      | `v`      | rad/s, m/s    | velocities                                     |
    /// | a      | `a`      | rad/s^2, m/s^2| accelerations, `v'`                            |
    /// | tau    | `tau`    | Nm, N         | forces; a ball's and the turning half of a free joint's in the body's frame |
    ///
    /// # Shapes
    /// `q: [nq]`, the others `[nv]`.
    ///
    /// # Assumes
    /// Armature counts as inertia of the joint alone; damping, springs and dry friction are not part of it
    /// (see [`passive_force`](Robot::passive_force)), couplings neither.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] where an entry is not finite.
    ///
    /// # Source
    /// `featherstone2008`, table 5.1, with accelerations of points instead of spatial ones.
    #[doc(alias = "rnea")]
    #[doc(alias = "newton_euler")]
    pub fn inverse_dynamics(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        scratch: &mut Scratch,
        tau: &mut [f64],
    ) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        self.check_velocities("a", a)?;
        self.newton_euler(q, v, a, scale(-1.0, self.parts().gravity), scratch, tau)
    }

    /// Forces that velocities and gravity ask for: `c(q, v) + g(q)`. MuJoCo's `qfrc_bias`.
    ///
    /// # Errors
    /// As [`inverse_dynamics`](Robot::inverse_dynamics).
    pub fn bias_force(
        &self,
        q: &[f64],
        v: &[f64],
        scratch: &mut Scratch,
        tau: &mut [f64],
    ) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        let rest = core::mem::take(&mut scratch.rest);
        let done = self.newton_euler(q, v, &rest, scale(-1.0, self.parts().gravity), scratch, tau);
        scratch.rest = rest;
        done
    }

    /// Forces that hold the pose against gravity, `g(q)`.
    ///
    /// # Errors
    /// As [`inverse_dynamics`](Robot::inverse_dynamics).
    pub fn gravity_force(&self, q: &[f64], scratch: &mut Scratch, tau: &mut [f64]) -> Result<(), Error> {
        self.check_coordinates(q)?;
        let rest = core::mem::take(&mut scratch.rest);
        let done = self.newton_euler(q, &rest, &rest, scale(-1.0, self.parts().gravity), scratch, tau);
        scratch.rest = rest;
        done
    }

    /// Forces of velocities alone, `c(q, v)`.
    ///
    /// # Errors
    /// As [`inverse_dynamics`](Robot::inverse_dynamics).
    pub fn velocity_force(
        &self,
        q: &[f64],
        v: &[f64],
        scratch: &mut Scratch,
        tau: &mut [f64],
    ) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        let rest = core::mem::take(&mut scratch.rest);
        let done = self.newton_euler(q, v, &rest, [0.0; 3], scratch, tau);
        scratch.rest = rest;
        done
    }

    /// The two passes, with the acceleration of the ground given.
    fn newton_euler(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        ground: Vector,
        scratch: &mut Scratch,
        tau: &mut [f64],
    ) -> Result<(), Error> {
        let links = &self.tree.links;
        super::robot::length("scratch", scratch.links.len(), links.len())?;
        super::robot::length("tau", tau.len(), self.nv())?;
        let moving = &mut scratch.links[..];
        moving[0] = Moving { acceleration: ground, ..Moving::default() };
        for (index, link) in links.iter().enumerate().skip(1) {
            moving[index] = outward(link, &moving[link.parent], q, v, a);
        }
        for (index, link) in links.iter().enumerate().skip(1).rev() {
            let own = moving[index];
            hand_out(link, &own, a, tau);
            let force = rotate(&own.axes, own.force);
            let parent = &mut moving[link.parent];
            parent.force = add(parent.force, force);
            parent.moment = add(add(parent.moment, rotate(&own.axes, own.moment)), cross(own.origin, force));
        }
        numbers("tau", tau, self.nv())
    }
}

/// Motion of a link from its parent's, and the load that this motion asks for.
#[inline]
fn outward(link: &Link, parent: &Moving, q: &[f64], v: &[f64], a: &[f64]) -> Moving {
    let (axes, origin) = link.pose_in_parent(q);
    let omega = unrotate(&axes, parent.omega);
    let alpha = unrotate(&axes, parent.alpha);
    let centripetal = cross(parent.omega, cross(parent.omega, origin));
    let carried = add(add(parent.acceleration, cross(parent.alpha, origin)), centripetal);
    let carried = unrotate(&axes, carried);
    let [v, a] = [&v[link.v..], &a[link.v..]];
    let (omega, alpha, acceleration) = match link.kind {
        JointKind::Hinge => {
            let (rate, [x, y, z]) = (v[0], omega);
            let alpha = [alpha[0] + y * rate, alpha[1] - x * rate, alpha[2] + a[0]];
            ([x, y, z + rate], alpha, carried)
        }
        JointKind::Slide => {
            let coriolis = cross(scale(2.0, omega), [0.0, 0.0, v[0]]);
            (omega, alpha, add(add(carried, coriolis), [0.0, 0.0, a[0]]))
        }
        JointKind::Ball => {
            let rate = [v[0], v[1], v[2]];
            let alpha = add(add(alpha, cross(omega, rate)), [a[0], a[1], a[2]]);
            (add(omega, rate), alpha, carried)
        }
        JointKind::Free => {
            let fall = sub([a[0], a[1], a[2]], scale(-1.0, parent.acceleration));
            ([v[3], v[4], v[5]], [a[3], a[4], a[5]], unrotate(&axes, fall))
        }
    };
    let body = &link.inertia;
    let turning = add(cross(alpha, body.moment), cross(omega, cross(omega, body.moment)));
    let force = add_scaled(turning, body.mass, acceleration);
    let spin = symmetric(&body.about_origin, omega);
    let moment = add(symmetric(&body.about_origin, alpha), cross(omega, spin));
    let moment = add(moment, cross(body.moment, acceleration));
    Moving { axes, origin, omega, velocity: [0.0; 3], alpha, acceleration, force, moment }
}

/// The part of a link's load that its joint feels.
#[inline]
fn hand_out(link: &Link, own: &Moving, a: &[f64], tau: &mut [f64]) {
    match link.kind {
        JointKind::Hinge => tau[link.v] = own.moment[2] + link.armature * a[link.v],
        JointKind::Slide => tau[link.v] = own.force[2] + link.armature * a[link.v],
        JointKind::Ball => {
            for (k, moment) in own.moment.into_iter().enumerate() {
                tau[link.v + k] = moment + link.armature * a[link.v + k];
            }
        }
        JointKind::Free => {
            let force = rotate(&own.axes, own.force);
            for (k, load) in force.into_iter().chain(own.moment).enumerate() {
                tau[link.v + k] = load + link.armature * a[link.v + k];
            }
        }
    }
}
