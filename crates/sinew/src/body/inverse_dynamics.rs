use super::kinematics::PoseRows;
use super::link::Link;
use super::link_state::{LinkMotion, Wrench};
use super::lumped::{LumpedLink, axes_of, set_axes};
use super::parts::JointKind;
use super::robot::Robot;
use super::scratch::Scratch;
use super::tree::Tree;
use super::vector::{Frame, Vector, add, add_scaled, cross, dot, rotate, scale, unrotate};
use crate::dispatch::{Arithmetic, InstructionSet, Plain, Work};
use crate::error::{Error, check_entries, check_length};
use crate::lanes::Row;

impl Link {
    /// Axes and origin in the parent's frame.
    #[inline]
    pub(super) fn pose_in_parent(&self, q: &[f64]) -> (Frame, Vector) {
        let mut start = PoseRows::<1>::default();
        start.axes.set(0, self.axes);
        start.origin.set(0, self.origin);
        let PoseRows { axes, origin } = start.moved(self, Row([self.reference]), q.as_chunks().0);
        (axes.at(0), origin.at(0))
    }
}

impl Robot {
    /// Generalised forces for given accelerations.
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
    /// | tau    | `tau`    | Nm, N         | forces; rotational ones of ball and free joints in the body's frame |
    ///
    /// # Shapes
    /// `q: [nq]`, the others `[nv]`.
    ///
    /// # Assumes
    /// Armature counts as inertia of the joint alone; damping, springs and dry friction are not part of it
    /// (see [`passive_force`](Robot::passive_force)), couplings neither.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
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
        let checked = || {
            self.check_coordinates(q)?;
            self.check_velocities("v", v)?;
            self.check_velocities("a", a)
        };
        // With hinges alone, an input that is not finite gives an output that is not finite, and the inputs
        // are searched only then. With a free joint some inputs do not affect any force, so all are checked
        // first.
        if self.tree.chains.iter().all(|chain| chain.hinges) {
            check_length("q", q.len(), self.nq())?;
            check_length("v", v.len(), self.nv())?;
            check_length("a", a.len(), self.nv())?;
        } else {
            checked()?;
        }
        let done = self.newton_euler(q, v, a, scale(-1.0, self.parts().gravity), scratch, tau);
        if done.is_err() {
            checked()?;
        }
        done
    }

    /// Forces that balance gravity, `g(q)`, without [what holds bodies](Robot::gravity_compensation).
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

    /// The two passes for a given acceleration of the ground.
    fn newton_euler(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        ground: Vector,
        scratch: &mut Scratch,
        tau: &mut [f64],
    ) -> Result<(), Error> {
        check_length("scratch", scratch.wrenches.len(), self.tree.links.len())?;
        check_length("tau", tau.len(), self.nv())?;
        let passes = Passes { tree: &self.tree, q, v, a, ground, scratch, tau: &mut *tau };
        InstructionSet::detect_narrow().run(passes);
        check_entries("tau", tau, self.nv())
    }
}

/// Recursive Newton-Euler: motions from the ground outward, wrenches from the leaves inward.
struct Passes<'a> {
    tree: &'a Tree,
    q: &'a [f64],
    v: &'a [f64],
    a: &'a [f64],
    ground: Vector,
    scratch: &'a mut Scratch,
    tau: &'a mut [f64],
}

impl Work for Passes<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(mut self, by: A) {
        self.rotate_axes();
        self.outward(by);
        self.inward(by);
    }
}

impl Passes<'_> {
    /// Axes of all links; other joints than hinges at their references.
    #[inline(always)]
    fn rotate_axes(&mut self) {
        for (quad, turned) in self.tree.quads.iter().zip(&mut self.scratch.turned) {
            quad.turned(self.q, turned);
        }
    }

    #[inline(always)]
    fn outward<A: Arithmetic>(&mut self, by: A) {
        let Tree { links, lumped_links, chains, .. } = self.tree;
        let Scratch { turned, motions, wrenches, .. } = &mut *self.scratch;
        for chain in chains {
            let mut motion = if chain.parent == 0 {
                LinkMotion { a: self.ground, ..LinkMotion::default() }
            } else {
                motions[chain.parent]
            };
            if chain.hinges {
                let all = chain.first..chain.last + 1;
                let rates = self.v[chain.v..].iter().zip(&self.a[chain.v..]);
                let entries = lumped_links[all.clone()].iter().zip(&mut wrenches[all.clone()]).zip(rates);
                for (((lumped, wrench), (v, a)), index) in entries.zip(all) {
                    motion = propagate_hinge(
                        by,
                        &motion,
                        &axes_of(&turned[index / 4], index % 4),
                        lumped.origin,
                        *v,
                        *a,
                    );
                    *wrench = flat_wrench(by, lumped, &motion);
                }
            } else {
                let link = &links[chain.first];
                let (axes, origin) = link.pose_in_parent(self.q);
                set_axes(&mut turned[chain.first / 4], chain.first % 4, &axes);
                motion = propagate(link, &motion, &axes, origin, &self.v[link.v..], &self.a[link.v..]);
                wrenches[chain.first] = full_wrench(&lumped_links[chain.first], &motion);
            }
            if chain.carries {
                motions[chain.last] = motion;
            }
        }
    }

    #[inline(always)]
    fn inward<A: Arithmetic>(&mut self, by: A) {
        let Tree { links, lumped_links, chains, .. } = self.tree;
        let Scratch { turned, wrenches, .. } = &mut *self.scratch;
        for chain in chains.iter().rev() {
            let mut carried = Wrench::default();
            if chain.hinges {
                let all = chain.first..chain.last + 1;
                let joints = chain.v..chain.v + all.len();
                let joints = self.a[joints.clone()].iter().zip(&mut self.tau[joints]);
                let entries = lumped_links[all.clone()].iter().zip(&wrenches[all.clone()]).zip(joints);
                for (((lumped, wrench), (a, tau)), index) in entries.zip(all).rev() {
                    let wrench = wrench.plus(&carried);
                    *tau = by.mul_add(lumped.armature, *a, wrench.moment[2]);
                    carried = wrench.on_parent(by, &axes_of(&turned[index / 4], index % 4), lumped.origin);
                }
            } else {
                let (link, wrench, axes) = (
                    &links[chain.first],
                    wrenches[chain.first],
                    axes_of(&turned[chain.first / 4], chain.first % 4),
                );
                wrench.project_to_joint(link, &axes, self.a, self.tau);
                carried = wrench.on_parent(Plain, &axes, link.pose_in_parent(self.q).1);
            }
            if chain.parent != 0 {
                wrenches[chain.parent] = wrenches[chain.parent].plus(&carried);
            }
        }
    }
}

/// `F v`.
#[inline(always)]
fn rotate_by<A: Arithmetic>(by: A, [x, y, z]: &Frame, v: Vector) -> Vector {
    [
        product(by, [x[0], y[0], z[0]], v),
        product(by, [x[1], y[1], z[1]], v),
        product(by, [x[2], y[2], z[2]], v),
    ]
}

#[inline(always)]
fn product<A: Arithmetic>(by: A, a: Vector, b: Vector) -> f64 {
    by.mul_add(a[2], b[2], by.mul_add(a[1], b[1], a[0] * b[0]))
}

/// `s + a . b`.
#[inline(always)]
fn product_onto<A: Arithmetic>(by: A, s: f64, a: Vector, b: Vector) -> f64 {
    by.mul_add(a[2], b[2], by.mul_add(a[1], b[1], by.mul_add(a[0], b[0], s)))
}

/// `F^T v`, which is also rows times `v`.
#[inline(always)]
fn rows_by<A: Arithmetic>(by: A, rows: &Frame, v: Vector) -> Vector {
    let [x, y, z] = *rows;
    [product(by, x, v), product(by, y, v), product(by, z, v)]
}

/// `U = [alpha] + [omega]^2`: `U r` is the acceleration of the point `r` relative to the origin.
#[inline(always)]
fn field<A: Arithmetic>(by: A, [x, y, z]: Vector, [a, b, c]: Vector) -> Frame {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        [-yy - zz, by.mul_add(x, y, -c), by.mul_add(x, z, b)],
        [by.mul_add(x, y, c), -xx - zz, by.mul_add(y, z, -a)],
        [by.mul_add(x, z, -b), by.mul_add(y, z, a), -xx - yy],
    ]
}

/// Motion of a link from its parent's through a hinge.
#[inline(always)]
fn propagate_hinge<A: Arithmetic>(
    by: A,
    parent: &LinkMotion,
    axes: &Frame,
    r: Vector,
    v: f64,
    a: f64,
) -> LinkMotion {
    let [x, y, z] = *axes;
    // The order of the sums keeps the dependency on the parent to one product per link.
    let (wx, wy) = (product(by, x, parent.omega), product(by, y, parent.omega));
    let omega = [wx, wy, product_onto(by, v, z, parent.omega)];
    let alpha = [
        product_onto(by, wy * v, x, parent.alpha),
        product_onto(by, -wx * v, y, parent.alpha),
        product_onto(by, a, z, parent.alpha),
    ];
    let a = rows_by(by, axes, add(parent.a, rows_by(by, &parent.field, r)));
    LinkMotion { omega, alpha, a, field: field(by, omega, alpha) }
}

/// Motion of a link from its parent's through any joint.
fn propagate(
    link: &Link,
    parent: &LinkMotion,
    axes: &Frame,
    origin: Vector,
    v: &[f64],
    a: &[f64],
) -> LinkMotion {
    let at = |place: Vector| add(parent.a, rows_by(Plain, &parent.field, place));
    let (omega, alpha) = (unrotate(axes, parent.omega), unrotate(axes, parent.alpha));
    let carried = unrotate(axes, at(origin));
    let (omega, alpha, a) = match link.kind {
        JointKind::Hinge | JointKind::Slide => {
            let coriolis = cross(scale(2.0, omega), [0.0, 0.0, v[0]]);
            (omega, alpha, add(add(carried, coriolis), [0.0, 0.0, a[0]]))
        }
        JointKind::Ball => {
            let rate = [v[0], v[1], v[2]];
            (add(omega, rate), add(add(alpha, cross(omega, rate)), [a[0], a[1], a[2]]), carried)
        }
        JointKind::Free => {
            let fall = add([a[0], a[1], a[2]], at([0.0; 3]));
            ([v[3], v[4], v[5]], [a[3], a[4], a[5]], unrotate(axes, fall))
        }
    };
    LinkMotion { omega, alpha, a, field: field(Plain, omega, alpha) }
}

/// Inertial wrench of a link, with first moments `h` and second moments `s` of its mass: the integrals over
/// the mass of `r x (a + U r)` and of `a + U r`.
fn full_wrench(lumped: &LumpedLink, LinkMotion { a, field: [x, y, z], .. }: &LinkMotion) -> Wrench {
    let h = lumped.moment;
    let [sxx, syy, szz, sxy, sxz, syz] = lumped.second;
    let rows = [[sxx, sxy, sxz], [sxy, syy, syz], [sxz, syz, szz]];
    let moment = [
        dot(*z, rows[1]) - dot(*y, rows[2]),
        dot(*x, rows[2]) - dot(*z, rows[0]),
        dot(*y, rows[0]) - dot(*x, rows[1]),
    ];
    let force = [dot(*x, h), dot(*y, h), dot(*z, h)];
    Wrench { moment: add(moment, cross(h, *a)), force: add_scaled(force, lumped.mass, *a) }
}

/// The same for a hinge's link, whose mass and moments along the axis are zero.
#[inline(always)]
fn flat_wrench<A: Arithmetic>(
    by: A,
    lumped: &LumpedLink,
    LinkMotion { a, field: [x, y, z], .. }: &LinkMotion,
) -> Wrench {
    let [hx, hy, _] = lumped.moment;
    let [sxx, syy, _, sxy, sxz, syz] = lumped.second;
    let zy = product(by, *z, [sxy, syy, syz]);
    let yz = by.mul_add(y[0], sxz, y[1] * syz);
    let xz = by.mul_add(x[0], sxz, x[1] * syz);
    let zx = product(by, *z, [sxx, sxy, sxz]);
    let yx = product(by, *y, [sxx, sxy, sxz]);
    let xy = product(by, *x, [sxy, syy, syz]);
    Wrench {
        moment: [
            by.mul_add(hy, a[2], zy - yz),
            by.mul_add(-hx, a[2], xz - zx),
            by.mul_add(hx, a[1], by.mul_add(-hy, a[0], yx - xy)),
        ],
        force: [
            by.mul_add(x[0], hx, x[1] * hy),
            by.mul_add(y[0], hx, y[1] * hy),
            by.mul_add(z[0], hx, z[1] * hy),
        ],
    }
}

impl Wrench {
    #[inline(always)]
    fn plus(&self, other: &Wrench) -> Wrench {
        Wrench { moment: add(self.moment, other.moment), force: add(self.force, other.force) }
    }

    /// The same wrench in the parent's frame, about its origin.
    #[inline(always)]
    fn on_parent<A: Arithmetic>(&self, by: A, axes: &Frame, [x, y, z]: Vector) -> Wrench {
        let force = rotate_by(by, axes, self.force);
        let [fx, fy, fz] = force;
        // Forces come first, so that the chain of dependent operations is that of the moments alone.
        let [lx, ly, lz] =
            [by.mul_add(y, fz, -z * fy), by.mul_add(z, fx, -x * fz), by.mul_add(x, fy, -y * fx)];
        let [ex, ey, ez] = axes;
        let moment = [
            product_onto(by, lx, [ex[0], ey[0], ez[0]], self.moment),
            product_onto(by, ly, [ex[1], ey[1], ez[1]], self.moment),
            product_onto(by, lz, [ex[2], ey[2], ez[2]], self.moment),
        ];
        Wrench { moment, force }
    }

    /// Projects the wrench on the joint's axes, and adds the armature.
    fn project_to_joint(&self, link: &Link, axes: &Frame, a: &[f64], tau: &mut [f64]) {
        let ([mx, my, mz], force) = (self.moment, self.force);
        let wrenches = match link.kind {
            JointKind::Hinge => [mz, 0.0, 0.0, 0.0, 0.0, 0.0],
            JointKind::Slide => [force[2], 0.0, 0.0, 0.0, 0.0, 0.0],
            JointKind::Ball => [mx, my, mz, 0.0, 0.0, 0.0],
            JointKind::Free => {
                let [x, y, z] = rotate(axes, force);
                [x, y, z, mx, my, mz]
            }
        };
        for (k, wrench) in wrenches.into_iter().enumerate().take(link.kind.velocities()) {
            tau[link.v + k] = wrench + link.armature * a[link.v + k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parts::Parts;
    use super::*;
    use alloc::vec;
    use alloc::vec::Vec;

    #[test]
    fn every_instruction_set_computes_the_same_but_for_rounding() {
        let bytes = include_str!("../../tests/golden/chain7.json");
        let mut golden: serde_json::Value = serde_json::from_str(bytes).unwrap();
        let parts: Parts = serde_json::from_value(golden["parts"].take()).unwrap();
        let robot = Robot::new(parts).unwrap();
        let numbers = |case: &serde_json::Value, name: &str| -> Vec<f64> {
            serde_json::from_value(case[name].clone()).unwrap()
        };
        for case in golden["cases"].as_array().unwrap() {
            let [q, v, a] = ["q", "v", "a"].map(|name| numbers(case, name));
            let on = |set: InstructionSet| {
                let (mut scratch, mut tau) = (Scratch::new(&robot), vec![0.0; robot.nv()]);
                let (scratch, tree) = (&mut scratch, &robot.tree);
                set.run(Passes {
                    tree,
                    q: &q,
                    v: &v,
                    a: &a,
                    ground: [0.0, 0.0, 9.81],
                    scratch,
                    tau: &mut tau,
                });
                tau
            };
            let plain = on(InstructionSet::Baseline);
            for set in InstructionSet::available() {
                for (tau, plain) in on(set).iter().zip(&plain) {
                    assert!((tau - plain).abs() < 1e-12 * (1.0 + plain.abs()), "{set:?}: {tau} {plain}");
                }
            }
        }
    }
}
