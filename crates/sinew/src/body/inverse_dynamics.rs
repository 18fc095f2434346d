use super::kinematics::orientation;
use super::lumped::{Stage, twice};
use super::parts::JointKind;
use super::robot::{Robot, length, numbers};
use super::scratch::Scratch;
use super::tree::Link;
use super::vector::{Frame, Vector, add, add_scaled, compose, cross, rotate, scale, turn_about_z, unrotate};
use crate::error::Error;
use crate::math::sincos_all;
use wide::f64x2;

/// Motion and load of one link, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Loaded {
    /// Axes in the parent's frame, every entry twice.
    axes: [[f64x2; 3]; 3],
    /// Origin in the parent's frame.
    origin: Vector,
    /// Angular velocity and acceleration, side by side.
    spin: [f64x2; 3],
    /// How places in the frame accelerate.
    field: Field,
    /// Moment about the origin and force on the link, side by side.
    load: [f64x2; 3],
}

/// Accelerations in a frame, against free fall: `a + U r` at the place `r`, `U = [alpha] + [omega]^2`. The first two
/// components lie side by side, so that they are read as they were written.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Field {
    /// `a`, then the columns of `U`.
    pairs: [f64x2; 4],
    /// The third row of `U` but for its end.
    bottom: f64x2,
    /// The ends of `a` and of the third row.
    ends: [f64; 2],
}

impl Field {
    #[inline]
    fn new(a: Vector, [x, y, z]: &Frame) -> Field {
        Field {
            pairs: [
                f64x2::new([a[0], a[1]]),
                f64x2::new([x[0], y[0]]),
                f64x2::new([x[1], y[1]]),
                f64x2::new([x[2], y[2]]),
            ],
            bottom: f64x2::new([z[0], z[1]]),
            ends: [a[2], z[2]],
        }
    }

    #[inline]
    fn at(&self, r: Vector) -> Vector {
        let [a, x, y, z] = self.pairs;
        let pair = (a + x * f64x2::splat(r[0])) + (y * f64x2::splat(r[1]) + z * f64x2::splat(r[2]));
        let [first, second] = pair.to_array();
        let [u, v] = (self.bottom * f64x2::new([r[0], r[1]])).to_array();
        [first, second, (self.ends[0] + self.ends[1] * r[2]) + (u + v)]
    }
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
        let tree = &self.tree;
        length("scratch", scratch.loaded.len(), tree.links.len())?;
        length("tau", tau.len(), self.nv())?;
        let loaded = &mut scratch.loaded[..];
        loaded[0] = Loaded { field: Field::new(ground, &Frame::default()), ..Loaded::default() };
        let [angles, sines, cosines] = &mut scratch.turns;
        for (link, angle) in tree.links.iter().zip(angles.iter_mut()).skip(1) {
            if link.kind == JointKind::Hinge {
                *angle = q[link.q] - link.reference;
            }
        }
        sincos_all(angles, sines, cosines);
        for (index, (link, stage)) in tree.links.iter().zip(&tree.stages).enumerate().skip(1) {
            // Written where they stay: a copy would have to wait for what was just stored.
            let (before, own) = loaded.split_at_mut(index);
            let (parent, own) = (&before[link.parent], &mut own[0]);
            if link.kind == JointKind::Hinge {
                turn(&stage.axes, sines[index], cosines[index], &mut own.axes);
                own.origin = link.origin;
                hinge_outward(stage, parent, own, link.origin, [v[link.v], a[link.v]]);
            } else {
                outward(link, stage, parent, own, q, v, a);
            }
        }
        // What comes from the link just dealt with, if it stands on this one: in a chain it always does.
        let mut carried = [f64x2::ZERO; 3];
        for (index, link) in tree.links.iter().enumerate().skip(1).rev() {
            let (before, own) = loaded.split_at_mut(index);
            let (parent, own) = (&mut before[link.parent], &own[0]);
            let load = sum(own.load, carried);
            match link.kind {
                JointKind::Hinge => tau[link.v] = low(load[2]) + link.armature * a[link.v],
                _ => hand_out(link, own, load, a, tau),
            }
            carried = inward(own, load);
            if link.parent + 1 != index {
                parent.load = sum(parent.load, carried);
                carried = [f64x2::ZERO; 3];
            }
        }
        numbers("tau", tau, self.nv())
    }
}

/// Rotations of two vectors at once: the axes have every entry twice.
#[inline]
fn rotate_both(axes: &[[f64x2; 3]; 3], v: [f64x2; 3]) -> [f64x2; 3] {
    let ([x, y, z], [a, b, c]) = (axes, v);
    [x[0] * a + y[0] * b + z[0] * c, x[1] * a + y[1] * b + z[1] * c, x[2] * a + y[2] * b + z[2] * c]
}

#[inline]
fn unrotate_both(axes: &[[f64x2; 3]; 3], v: [f64x2; 3]) -> [f64x2; 3] {
    let ([x, y, z], [a, b, c]) = (axes, v);
    [x[0] * a + x[1] * b + x[2] * c, y[0] * a + y[1] * b + y[2] * c, z[0] * a + z[1] * b + z[2] * c]
}

/// `[alpha] + [omega]^2`, row by row: times a place, the acceleration it has against the origin.
#[inline]
fn field(omega: Vector, alpha: Vector) -> Frame {
    let ([x, y, z], [a, b, c]) = (omega, alpha);
    let (xx, yy, zz, xy, xz, yz) = (x * x, y * y, z * z, x * y, x * z, y * z);
    [[-yy - zz, xy - c, xz + b], [xy + c, -xx - zz, yz - a], [xz - b, yz + a, -xx - yy]]
}

/// Moment and force that the motion asks for, with first moments `h` and second moments `s` of the mass:
/// the sums over it of `r x (a + U r)` and of `a + U r`.
#[inline]
fn load(stage: &Stage, [x, y, z]: &Frame, a: Vector) -> [f64x2; 3] {
    let ([hx, hy, hz], m) = (stage.moment, stage.mass);
    let [sxx, syy, szz, sxy, sxz, syz] = stage.second;
    let zy = z[0] * sxy + z[1] * syy + z[2] * syz;
    let yz = y[0] * sxz + y[1] * syz + y[2] * szz;
    let xz = x[0] * sxz + x[1] * syz + x[2] * szz;
    let zx = z[0] * sxx + z[1] * sxy + z[2] * sxz;
    let yx = y[0] * sxx + y[1] * sxy + y[2] * sxz;
    let xy = x[0] * sxy + x[1] * syy + x[2] * syz;
    [
        f64x2::new([zy - yz + (hy * a[2] - hz * a[1]), m * a[0] + (x[0] * hx + x[1] * hy + x[2] * hz)]),
        f64x2::new([xz - zx + (hz * a[0] - hx * a[2]), m * a[1] + (y[0] * hx + y[1] * hy + y[2] * hz)]),
        f64x2::new([yx - xy + (hx * a[1] - hy * a[0]), m * a[2] + (z[0] * hx + z[1] * hy + z[2] * hz)]),
    ]
}

/// The same where a hinge's link keeps nothing along its axis.
#[inline]
fn flat_load(stage: &Stage, [x, y, z]: &Frame, a: Vector) -> [f64x2; 3] {
    let [hx, hy, _] = stage.moment;
    let [sxx, syy, _, sxy, sxz, syz] = stage.second;
    let zy = z[0] * sxy + z[1] * syy + z[2] * syz;
    let yz = y[0] * sxz + y[1] * syz;
    let xz = x[0] * sxz + x[1] * syz;
    let zx = z[0] * sxx + z[1] * sxy + z[2] * sxz;
    let yx = y[0] * sxx + y[1] * sxy + y[2] * sxz;
    let xy = x[0] * sxy + x[1] * syy + x[2] * syz;
    // Sums of pairs, not pairs of sums: pairs are then stored, and read again, whole.
    [
        f64x2::new([zy - yz, x[0] * hx]) + f64x2::new([hy * a[2], x[1] * hy]),
        f64x2::new([xz - zx, y[0] * hx]) - f64x2::new([hx * a[2], -y[1] * hy]),
        f64x2::new([yx - xy, z[0] * hx]) + f64x2::new([hx * a[1] - hy * a[0], z[1] * hy]),
    ]
}

/// Axes turned about their own z.
#[inline]
fn turn(axes: &[[f64x2; 3]; 3], sine: f64, cosine: f64, turned: &mut [[f64x2; 3]; 3]) {
    let (s, c) = (f64x2::splat(sine), f64x2::splat(cosine));
    let [x, y, z] = axes;
    for i in 0..3 {
        turned[0][i] = c * x[i] + s * y[i];
        turned[1][i] = c * y[i] - s * x[i];
    }
    turned[2] = *z;
}

/// Motion of a link behind a hinge, and the load that this motion asks for.
#[inline]
fn hinge_outward(stage: &Stage, parent: &Loaded, own: &mut Loaded, origin: Vector, [v, a]: [f64; 2]) {
    let [x, y, z] = unrotate_both(&own.axes, parent.spin);
    let ([wx, _], [wy, _]) = (x.to_array(), y.to_array());
    let x = x + f64x2::new([0.0, wy * v]);
    let y = y - f64x2::new([0.0, wx * v]);
    let z = z + f64x2::new([v, a]);
    own.spin = [x, y, z];
    let ([_, ax], [_, ay], [wz, az]) = (x.to_array(), y.to_array(), z.to_array());
    // Not own.origin: read back at once it would have to wait until it is stored.
    let [bx, by, bz] = parent.field.at(origin);
    let [ex, ey, ez] = &own.axes;
    let both = |i: usize| f64x2::new([low(ex[i]), low(ey[i])]);
    let flat = both(0) * f64x2::splat(bx) + both(1) * f64x2::splat(by) + both(2) * f64x2::splat(bz);
    let third = low(ez[0]) * bx + low(ez[1]) * by + low(ez[2]) * bz;
    let (w, square) = (f64x2::new([wx, wy]), wx * wx + wy * wy + wz * wz);
    let columns = [
        w * f64x2::splat(wx) + f64x2::new([-square, az]),
        w * f64x2::splat(wy) - f64x2::new([az, square]),
        w * f64x2::splat(wz) + f64x2::new([ay, -ax]),
    ];
    let bottom = w * f64x2::splat(wz) - f64x2::new([ay, -ax]);
    let end = -(wx * wx + wy * wy);
    own.field.pairs = [flat, columns[0], columns[1], columns[2]];
    own.field.bottom = bottom;
    own.field.ends = [third, end];
    own.load = if stage.weightless {
        [f64x2::ZERO; 3]
    } else {
        let ([x0, y0], [x1, y1], [x2, y2]) =
            (columns[0].to_array(), columns[1].to_array(), columns[2].to_array());
        let ([first, second], [z0, z1]) = (flat.to_array(), bottom.to_array());
        flat_load(stage, &[[x0, x1, x2], [y0, y1, y2], [z0, z1, end]], [first, second, third])
    };
}

/// The first of two.
#[inline]
fn low(pair: f64x2) -> f64 {
    pair.to_array()[0]
}

/// A link's load as what carries it feels it.
#[inline]
fn inward(own: &Loaded, load: [f64x2; 3]) -> [f64x2; 3] {
    let [a, b, c] = rotate_both(&own.axes, load);
    let ([_, fx], [_, fy], [_, fz]) = (a.to_array(), b.to_array(), c.to_array());
    let [x, y, z] = cross(own.origin, [fx, fy, fz]);
    [a + f64x2::new([x, 0.0]), b + f64x2::new([y, 0.0]), c + f64x2::new([z, 0.0])]
}

#[inline]
fn sum(a: [f64x2; 3], b: [f64x2; 3]) -> [f64x2; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Motion of any link from its parent's, and the load that this motion asks for.
fn outward(link: &Link, stage: &Stage, parent: &Loaded, own: &mut Loaded, q: &[f64], v: &[f64], a: &[f64]) {
    let (axes, origin) = link.pose_in_parent(q);
    let both = twice(&axes);
    let inner = unrotate_both(&both, parent.spin).map(f64x2::to_array);
    let (omega, alpha) = (inner.map(|pair| pair[0]), inner.map(|pair| pair[1]));
    let carried = unrotate(&axes, parent.field.at(origin));
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
            let fall = add([a[0], a[1], a[2]], parent.field.at([0.0; 3]));
            ([v[3], v[4], v[5]], [a[3], a[4], a[5]], unrotate(&axes, fall))
        }
    };
    let field = field(omega, alpha);
    let spin = core::array::from_fn(|i| f64x2::new([omega[i], alpha[i]]));
    let load = load(stage, &field, acceleration);
    *own = Loaded { axes: both, origin, spin, field: Field::new(acceleration, &field), load };
}

/// The part of a link's load that its joint feels; hinges are dealt with where they are met.
fn hand_out(link: &Link, own: &Loaded, load: [f64x2; 3], a: &[f64], tau: &mut [f64]) {
    let pairs = load.map(f64x2::to_array);
    let (moment, force) = (pairs.map(|pair| pair[0]), pairs.map(|pair| pair[1]));
    let loads = match link.kind {
        JointKind::Hinge => [moment[2], 0.0, 0.0, 0.0, 0.0, 0.0],
        JointKind::Slide => [force[2], 0.0, 0.0, 0.0, 0.0, 0.0],
        JointKind::Ball => [moment[0], moment[1], moment[2], 0.0, 0.0, 0.0],
        JointKind::Free => {
            let axes = own.axes.map(|axis| axis.map(low));
            let [x, y, z] = rotate(&axes, force);
            [x, y, z, moment[0], moment[1], moment[2]]
        }
    };
    for (k, load) in loads.into_iter().enumerate().take(link.kind.velocities()) {
        tau[link.v + k] = load + link.armature * a[link.v + k];
    }
}
