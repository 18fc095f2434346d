use super::kinematics::orientation;
use super::lumped::{Stage, twice};
use super::parts::JointKind;
use super::robot::{Robot, length, numbers};
use super::scratch::Scratch;
use super::tree::Link;
use super::vector::{
    Frame, Vector, add, add_scaled, compose, cross, dot, rotate, scale, turn_about_z, unrotate,
};
use crate::error::Error;
use crate::math::sincos;
use wide::f64x2;

/// Motion and load of one link, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Loaded {
    /// Turn of a hinge.
    turn: (f64, f64),
    /// Angular velocity and acceleration, side by side.
    spin: [f64x2; 3],
    /// Acceleration of the origin, against free fall.
    acceleration: Vector,
    /// What a place in the frame has for its own acceleration: `[alpha] + [omega]^2`, row by row.
    field: Frame,
    /// Moment about the origin and force on the link, side by side.
    load: [f64x2; 3],
}

impl Link {
    /// Axes and origin in the parent's frame.
    #[inline]
    pub(super) fn pose_in_parent(&self, q: &[f64]) -> (Frame, Vector) {
        match self.kind {
            JointKind::Hinge => (turn_about_z(&self.axes, sincos(q[self.q] - self.reference)), self.origin),
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
        let tree = &self.tree;
        length("scratch", scratch.loaded.len(), tree.links.len())?;
        length("tau", tau.len(), self.nv())?;
        let loaded = &mut scratch.loaded[..];
        loaded[0] = Loaded { acceleration: ground, ..Loaded::default() };
        for (index, (link, stage)) in tree.links.iter().zip(&tree.stages).enumerate().skip(1) {
            // Written where they stay: a copy would have to wait for what was just stored.
            let (before, own) = loaded.split_at_mut(index);
            let (parent, own) = (&before[link.parent], &mut own[0]);
            match link.kind {
                JointKind::Hinge => {
                    hinge_outward(link, stage, parent, own, [q[link.q], v[link.v], a[link.v]]);
                }
                _ => outward(link, stage, parent, own, q, v, a),
            }
        }
        for (index, (link, stage)) in tree.links.iter().zip(&tree.stages).enumerate().skip(1).rev() {
            let (before, own) = loaded.split_at_mut(index);
            let (parent, own) = (&mut before[link.parent], &own[0]);
            if link.kind == JointKind::Hinge {
                tau[link.v] = own.load[2].as_array()[0] + link.armature * a[link.v];
                if link.parent != 0 {
                    hinge_inward(link, stage, own, parent);
                }
            } else {
                hand_out(link, own, q, a, tau);
                inward(link, own, q, parent);
            }
        }
        numbers("tau", tau, self.nv())
    }
}

/// Rotations of two vectors at once: the axes have every entry twice.
#[inline]
fn rotate_both(axes: &[[f64x2; 3]; 3], v: [f64x2; 3]) -> [f64x2; 3] {
    let [x, y, z] = axes;
    core::array::from_fn(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
}

#[inline]
fn unrotate_both(axes: &[[f64x2; 3]; 3], v: [f64x2; 3]) -> [f64x2; 3] {
    core::array::from_fn(|k| axes[k][0] * v[0] + axes[k][1] * v[1] + axes[k][2] * v[2])
}

/// `[alpha] + [omega]^2`, row by row: times a place, the acceleration it has against the origin.
#[inline]
fn field(omega: Vector, alpha: Vector) -> Frame {
    let ([x, y, z], [a, b, c]) = (omega, alpha);
    let (xx, yy, zz, xy, xz, yz) = (x * x, y * y, z * z, x * y, x * z, y * z);
    [[-yy - zz, xy - c, xz + b], [xy + c, -xx - zz, yz - a], [xz - b, yz + a, -xx - yy]]
}

/// Moment and force that the motion asks for, with the second moments `s` of the mass:
/// `m = sum over mass of r x (a + U r)`.
#[inline]
fn load(stage: &Stage, u: &Frame, a: Vector, flat: bool) -> [f64x2; 3] {
    let [hx, hy, hz] = stage.moment;
    let [xx, yy, zz, xy, xz, yz] = stage.second;
    let columns = if flat {
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, 0.0]]
    } else {
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    };
    let product = |i: usize, j: usize| {
        let sum = u[i][0] * columns[j][0] + u[i][1] * columns[j][1];
        if flat && j == 2 { sum } else { sum + u[i][2] * columns[j][2] }
    };
    let mut moment = [
        product(2, 1) - product(1, 2) + hy * a[2],
        product(0, 2) - product(2, 0) - hx * a[2],
        product(1, 0) - product(0, 1) + (hx * a[1] - hy * a[0]),
    ];
    let mut force: Vector = core::array::from_fn(|i| u[i][0] * hx + u[i][1] * hy);
    if !flat {
        moment = [moment[0] - hz * a[1], moment[1] + hz * a[0], moment[2]];
        force = core::array::from_fn(|i| force[i] + u[i][2] * hz + stage.mass * a[i]);
    }
    core::array::from_fn(|i| f64x2::new([moment[i], force[i]]))
}

/// Motion of a link behind a hinge, and the load that this motion asks for.
#[inline]
fn hinge_outward(link: &Link, stage: &Stage, parent: &Loaded, own: &mut Loaded, [q, v, a]: [f64; 3]) {
    let turn = sincos(q - link.reference);
    let (sine, cosine) = turn;
    let [x, y, z] = unrotate_both(&stage.axes, parent.spin);
    let (s, c) = (f64x2::splat(sine), f64x2::splat(cosine));
    let ([x, ax], [y, ay]) = ((c * x + s * y).to_array(), (c * y - s * x).to_array());
    let z = z + f64x2::new([v, a]);
    let (ax, ay) = (ax + y * v, ay - x * v);
    let [wz, az] = z.to_array();
    let carried: Vector =
        core::array::from_fn(|i| parent.acceleration[i] + dot(parent.field[i], link.origin));
    let [bx, by, bz] = unrotate(&link.axes, carried);
    let acceleration = [cosine * bx + sine * by, cosine * by - sine * bx, bz];
    let field = field([x, y, wz], [ax, ay, az]);
    own.turn = turn;
    own.spin = [f64x2::new([x, ax]), f64x2::new([y, ay]), z];
    own.acceleration = acceleration;
    own.field = field;
    own.load = if stage.weightless { [f64x2::ZERO; 3] } else { load(stage, &field, acceleration, true) };
}

/// Hands a link's load through its hinge to what carries it.
#[inline]
fn hinge_inward(link: &Link, stage: &Stage, own: &Loaded, parent: &mut Loaded) {
    let (s, c) = (f64x2::splat(own.turn.0), f64x2::splat(own.turn.1));
    let [x, y, z] = own.load;
    give(rotate_both(&stage.axes, [c * x - s * y, s * x + c * y, z]), link.origin, parent);
}

/// Adds moment and force at a place to a link's load.
#[inline]
fn give(load: [f64x2; 3], place: Vector, parent: &mut Loaded) {
    let force = load.map(|pair| pair.to_array()[1]);
    let lever = cross(place, force);
    for i in 0..3 {
        parent.load[i] += load[i] + f64x2::new([lever[i], 0.0]);
    }
}

/// Motion of any link from its parent's, and the load that this motion asks for.
fn outward(link: &Link, stage: &Stage, parent: &Loaded, own: &mut Loaded, q: &[f64], v: &[f64], a: &[f64]) {
    let (axes, origin) = link.pose_in_parent(q);
    let inner = unrotate_both(&twice(&axes), parent.spin).map(f64x2::to_array);
    let (omega, alpha) = (inner.map(|pair| pair[0]), inner.map(|pair| pair[1]));
    let carried: Vector = core::array::from_fn(|i| parent.acceleration[i] + dot(parent.field[i], origin));
    let carried = unrotate(&axes, carried);
    let [v, a] = [&v[link.v..], &a[link.v..]];
    let (omega, alpha, acceleration) = match link.kind {
        JointKind::Hinge | JointKind::Slide => {
            let coriolis = cross(scale(2.0, omega), [0.0, 0.0, v[0]]);
            (omega, alpha, add(add(carried, coriolis), [0.0, 0.0, a[0]]))
        }
        JointKind::Ball => {
            let rate = [v[0], v[1], v[2]];
            (add(omega, rate), add(add(alpha, cross(omega, rate)), [a[0], a[1], a[2]]), carried)
        }
        JointKind::Free => {
            let fall = add([a[0], a[1], a[2]], parent.acceleration);
            ([v[3], v[4], v[5]], [a[3], a[4], a[5]], unrotate(&axes, fall))
        }
    };
    let field = field(omega, alpha);
    let spin = core::array::from_fn(|i| f64x2::new([omega[i], alpha[i]]));
    let load = load(stage, &field, acceleration, false);
    *own = Loaded { turn: (0.0, 1.0), spin, acceleration, field, load };
}

/// Hands a link's load to what carries it, whatever its joint.
fn inward(link: &Link, own: &Loaded, q: &[f64], parent: &mut Loaded) {
    let (axes, origin) = link.pose_in_parent(q);
    give(rotate_both(&twice(&axes), own.load), origin, parent);
}

/// The part of a link's load that its joint feels; hinges are dealt with where they are met.
fn hand_out(link: &Link, own: &Loaded, q: &[f64], a: &[f64], tau: &mut [f64]) {
    let pairs = own.load.map(f64x2::to_array);
    let (moment, force) = (pairs.map(|pair| pair[0]), pairs.map(|pair| pair[1]));
    let loads = match link.kind {
        JointKind::Hinge => [moment[2], 0.0, 0.0, 0.0, 0.0, 0.0],
        JointKind::Slide => [force[2], 0.0, 0.0, 0.0, 0.0, 0.0],
        JointKind::Ball => [moment[0], moment[1], moment[2], 0.0, 0.0, 0.0],
        JointKind::Free => {
            let [x, y, z] = rotate(&link.pose_in_parent(q).0, force);
            [x, y, z, moment[0], moment[1], moment[2]]
        }
    };
    for (k, load) in loads.into_iter().enumerate().take(link.kind.velocities()) {
        tau[link.v + k] = load + link.armature * a[link.v + k];
    }
}
