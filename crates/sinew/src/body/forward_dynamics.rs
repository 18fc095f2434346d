use super::link::{Inertia, Link};
use super::link_state::ArticulatedBody;
use super::parts::JointKind;
use super::robot::Robot;
use super::scratch::Scratch;
use super::vector::{
    Frame, IDENTITY, Vector, add, add_scaled, columns, compose, cross, dot, rotate, scale, sub, symmetric,
    transpose, unrotate,
};
use crate::error::{Error, check_entries, check_length};

impl ArticulatedBody {
    fn rigid(body: &Inertia, omega: Vector, velocity: Vector) -> ArticulatedBody {
        let coupling = columns(|k| cross(body.moment, IDENTITY[k]));
        let momentum = add_scaled(cross(omega, body.moment), body.mass, velocity);
        let spin = add(symmetric(&body.about_origin, omega), cross(body.moment, velocity));
        ArticulatedBody {
            angular: columns(|k| symmetric(&body.about_origin, IDENTITY[k])),
            coupling,
            linear: columns(|k| scale(body.mass, IDENTITY[k])),
            moment: add(cross(omega, spin), cross(velocity, momentum)),
            force: cross(omega, momentum),
            ..ArticulatedBody::default()
        }
    }

    #[inline]
    fn times(&self, turn: Vector, shift: Vector) -> (Vector, Vector) {
        let moment = add(rotate(&self.angular, turn), rotate(&self.coupling, shift));
        (moment, add(unrotate(&self.coupling, turn), rotate(&self.linear, shift)))
    }

    /// Projects out one velocity: the remaining inertia is that with this joint free under its force.
    fn eliminate(&mut self, (moment, force): (Vector, Vector), pivot: f64, left: f64) {
        for k in 0..3 {
            self.angular[k] = add_scaled(self.angular[k], -moment[k] / pivot, moment);
            self.coupling[k] = add_scaled(self.coupling[k], -force[k] / pivot, moment);
            self.linear[k] = add_scaled(self.linear[k], -force[k] / pivot, force);
        }
        self.moment = add_scaled(self.moment, left / pivot, moment);
        self.force = add_scaled(self.force, left / pivot, force);
    }

    /// Adds the articulated inertia and bias wrench of a child.
    fn add_child(&mut self, child: &ArticulatedBody, axes: &Frame, origin: Vector) {
        let (moment, force) = child.times(child.drift.0, child.drift.1);
        let force = rotate(axes, add(child.force, force));
        let moment = rotate(axes, add(child.moment, moment));
        self.force = add(self.force, force);
        self.moment = add(self.moment, add(moment, cross(origin, force)));
        let turned = |block: &Frame| compose(&compose(axes, block), &transpose(axes));
        let (angular, coupling, linear) =
            (turned(&child.angular), turned(&child.coupling), turned(&child.linear));
        let moved = columns(|k| add(coupling[k], cross(origin, linear[k])));
        let back = transpose(&moved);
        let arms = columns(|k| cross(origin, back[k]));
        for k in 0..3 {
            let lever = rotate(&coupling, cross(origin, IDENTITY[k]));
            self.angular[k] = add(self.angular[k], add(sub(angular[k], lever), arms[k]));
            self.coupling[k] = add(self.coupling[k], moved[k]);
            self.linear[k] = add(self.linear[k], linear[k]);
        }
    }
}

impl Robot {
    /// Accelerations under given forces.
    ///
    /// ```text
    /// a = M(q)^-1 (tau - c(q, v) - g(q))
    /// ```
    ///
    /// # Shapes
    /// `q: [nq]`, the others `[nv]`.
    ///
    /// # Assumes
    /// As [`inverse_dynamics`](Robot::inverse_dynamics): passive forces are part of `tau`, couplings are not
    /// held.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::EntryOutOfDomain`] where an entry is not finite, and [`Error::Part`]
    /// naming a joint that moves nothing with mass, so that `M` is singular.
    ///
    /// # Source
    /// `featherstone2008`, table 7.1; the velocities of one joint are eliminated one after the other.
    #[doc(alias = "aba")]
    pub fn forward_dynamics(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        scratch: &mut Scratch,
        a: &mut [f64],
    ) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        self.check_velocities("tau", tau)?;
        let links = &self.tree.links;
        check_length("scratch", scratch.links.len(), links.len())?;
        check_length("a", a.len(), self.nv())?;
        self.velocities(q, v, scratch);
        for (index, link) in links.iter().enumerate().skip(1) {
            let moving = &scratch.links[index];
            let mut own = ArticulatedBody::rigid(&link.inertia, moving.omega, moving.velocity);
            own.drift = drift(link, &moving.axes, moving.omega, moving.velocity, v);
            scratch.articulated[index] = own;
        }
        for (index, link) in links.iter().enumerate().skip(1).rev() {
            self.inward(index, link, tau, scratch)?;
        }
        let ground = scale(-1.0, self.parts().gravity);
        for (index, link) in links.iter().enumerate().skip(1) {
            let parent = match link.parent {
                0 => ([0.0; 3], ground),
                parent => scratch.articulated[parent].acceleration,
            };
            outward(link, parent, scratch, index, a);
        }
        check_entries("a", a, self.nv())
    }

    /// Poses and velocities of all links, each in its own frame.
    pub(super) fn velocities(&self, q: &[f64], v: &[f64], scratch: &mut Scratch) {
        for (index, link) in self.tree.links.iter().enumerate().skip(1) {
            let (axes, origin) = link.pose_in_parent(q);
            let (mut omega, mut velocity) = ([0.0; 3], [0.0; 3]);
            if link.parent != 0 {
                let parent = &scratch.links[link.parent];
                omega = unrotate(&axes, parent.omega);
                velocity = unrotate(&axes, add(parent.velocity, cross(parent.omega, origin)));
            }
            for k in 0..link.kind.velocities() {
                let (turn, shift) = link.subspace(&axes, k);
                omega = add_scaled(omega, v[link.v + k], turn);
                velocity = add_scaled(velocity, v[link.v + k], shift);
            }
            let moving = &mut scratch.links[index];
            (moving.axes, moving.origin) = (axes, origin);
            (moving.omega, moving.velocity) = (omega, velocity);
        }
    }

    fn inward(&self, index: usize, link: &Link, tau: &[f64], scratch: &mut Scratch) -> Result<(), Error> {
        let (axes, origin) = (scratch.links[index].axes, scratch.links[index].origin);
        let (before, rest) = scratch.articulated.split_at_mut(index);
        let own = &mut rest[0];
        for k in 0..link.kind.velocities() {
            let (turn, shift) = link.subspace(&axes, k);
            let (moment, force) = own.times(turn, shift);
            let rigid = dot(turn, moment) + dot(shift, force);
            let pivot = rigid + link.armature;
            let left = tau[link.v + k] - dot(turn, own.moment) - dot(shift, own.force);
            // Scale of rounding errors: the inertia of the link itself.
            let whole = own.linear[0][0].abs() + own.angular.iter().flatten().map(|x| x.abs()).sum::<f64>();
            if pivot.is_nan() || pivot <= 1e-14 * whole || pivot <= 0.0 {
                let expected = "above zero (mass on the bodies it moves, or armature)";
                let field = "the inertia it moves";
                return Err(Error::Part { kind: "joint", index: link.joint, field, expected });
            }
            scratch.pivots[link.v + k] = [left, pivot];
            scratch.columns[link.v + k] = [moment[0], moment[1], moment[2], force[0], force[1], force[2]];
            own.eliminate((moment, force), pivot, left);
        }
        if link.parent != 0 {
            before[link.parent].add_child(own, &axes, origin);
        }
        Ok(())
    }
}

/// Velocity-product acceleration of a link relative to its parent.
fn drift(link: &Link, axes: &Frame, omega: Vector, velocity: Vector, v: &[f64]) -> (Vector, Vector) {
    if link.kind == JointKind::Free {
        return ([0.0; 3], cross(scale(-1.0, omega), velocity));
    }
    let (mut turn, mut shift) = ([0.0; 3], [0.0; 3]);
    for k in 0..link.kind.velocities() {
        let (one_turn, one_shift) = link.subspace(axes, k);
        turn = add_scaled(turn, v[link.v + k], one_turn);
        shift = add_scaled(shift, v[link.v + k], one_shift);
    }
    (cross(omega, turn), add(cross(omega, shift), cross(velocity, turn)))
}

fn outward(link: &Link, parent: (Vector, Vector), scratch: &mut Scratch, index: usize, a: &mut [f64]) {
    let moving = &scratch.links[index];
    let own = &mut scratch.articulated[index];
    let carried = add(parent.1, cross(parent.0, moving.origin));
    let mut turn = add(unrotate(&moving.axes, parent.0), own.drift.0);
    let mut shift = add(unrotate(&moving.axes, carried), own.drift.1);
    for k in (0..link.kind.velocities()).rev() {
        let [left, pivot] = scratch.pivots[link.v + k];
        let [m0, m1, m2, f0, f1, f2] = scratch.columns[link.v + k];
        let resisted = dot([m0, m1, m2], turn) + dot([f0, f1, f2], shift);
        let one = (left - resisted) / pivot;
        let (one_turn, one_shift) = link.subspace(&moving.axes, k);
        turn = add_scaled(turn, one, one_turn);
        shift = add_scaled(shift, one, one_shift);
        a[link.v + k] = one;
    }
    own.acceleration = (turn, shift);
}
