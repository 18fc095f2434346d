use super::kinematics::PoseRows;
use super::link::{Link, LinkRows};
use super::link_state::{ArticulatedBody, ForwardScratch, LinkState};
use super::parts::JointKind;
use super::robot::Robot;
use super::scratch::Scratch;
use super::tree::Tree;
use super::vector::IDENTITY;
use crate::error::{Error, check_entries, check_length};
use crate::lanes::{Frame, Mask, Row, Vector};

/// Motion of a link along one of its velocities, in its own frame: about an axis, along z, or along a
/// direction.
#[derive(Clone, Copy)]
enum Way<const N: usize> {
    About(usize),
    AlongZ,
    Along(Vector<N>),
}

impl<const N: usize> Way<N> {
    /// Of the `k`th velocity of a link with these axes in its parent's frame.
    #[inline(always)]
    fn new(kind: JointKind, axes: &Frame<N>, k: usize) -> Self {
        match kind {
            JointKind::Hinge => Self::About(2),
            JointKind::Slide => Self::AlongZ,
            JointKind::Ball => Self::About(k),
            JointKind::Free if k < 3 => Self::Along(Vector([axes.0[0][k], axes.0[1][k], axes.0[2][k]])),
            JointKind::Free => Self::About(k - 3),
        }
    }

    /// Component of a wrench.
    #[inline(always)]
    fn of(self, [moment, force]: &[Vector<N>; 2]) -> Row<N> {
        match self {
            Self::About(axis) => moment[axis],
            Self::AlongZ => force[2],
            Self::Along(direction) => direction.dot(*force),
        }
    }

    /// Adds this motion, `amount` times.
    #[inline(always)]
    fn add(self, amount: Row<N>, [turn, shift]: &mut [Vector<N>; 2]) {
        match self {
            Self::About(axis) => turn[axis] += amount,
            Self::AlongZ => shift[2] += amount,
            Self::Along(direction) => *shift = *shift + amount * direction,
        }
    }
}

impl<const N: usize> ArticulatedBody<N> {
    #[inline(always)]
    fn rigid(rows: &LinkRows<N>, omega: Vector<N>, velocity: Vector<N>) -> Self {
        let (mass, m, none) = (rows.mass, rows.moment, Row::default());
        let [xx, yy, zz, xy, xz, yz] = rows.about_origin;
        let momentum = omega.cross(m) + mass * velocity;
        let angular = Frame([Vector([xx, xy, xz]), Vector([xy, yy, yz]), Vector([xz, yz, zz])]);
        let spin = Vector([
            xx * omega[0] + xy * omega[1] + xz * omega[2],
            xy * omega[0] + yy * omega[1] + yz * omega[2],
            xz * omega[0] + yz * omega[1] + zz * omega[2],
        ]) + m.cross(velocity);
        Self {
            angular,
            coupling: Frame([
                Vector([none, m[2], -m[1]]),
                Vector([-m[2], none, m[0]]),
                Vector([m[1], -m[0], none]),
            ]),
            linear: Frame([
                Vector([mass, none, none]),
                Vector([none, mass, none]),
                Vector([none, none, mass]),
            ]),
            moment: omega.cross(spin) + velocity.cross(momentum),
            force: omega.cross(momentum),
            ..Self::default()
        }
    }

    #[inline(always)]
    fn times(&self, [turn, shift]: [Vector<N>; 2]) -> [Vector<N>; 2] {
        let moment = self.angular.rotate(turn) + self.coupling.rotate(shift);
        [moment, self.coupling.unrotate(turn) + self.linear.rotate(shift)]
    }

    /// The same along one velocity.
    #[inline(always)]
    fn along(&self, way: Way<N>) -> [Vector<N>; 2] {
        let row = |frame: &Frame<N>, k: usize| Vector([frame.0[0][k], frame.0[1][k], frame.0[2][k]]);
        match way {
            Way::About(axis) => [self.angular.0[axis], row(&self.coupling, axis)],
            Way::AlongZ => [self.coupling.0[2], self.linear.0[2]],
            Way::Along(direction) => [self.coupling.rotate(direction), self.linear.rotate(direction)],
        }
    }

    /// Projects out one velocity: the remaining inertia is that with this joint free under its force.
    #[inline(always)]
    fn eliminate(&mut self, [moment, force]: [Vector<N>; 2], pivot: Row<N>, left: Row<N>) {
        for k in 0..3 {
            let (turn, shift) = (-moment[k] / pivot, -force[k] / pivot);
            self.angular.0[k] = self.angular.0[k] + turn * moment;
            self.coupling.0[k] = self.coupling.0[k] + shift * moment;
            self.linear.0[k] = self.linear.0[k] + shift * force;
        }
        let share = left / pivot;
        self.moment = self.moment + share * moment;
        self.force = self.force + share * force;
    }

    /// Adds the articulated inertia and bias wrench of a child.
    #[inline(always)]
    fn add_child(&mut self, child: &Self, axes: &Frame<N>, origin: Vector<N>) {
        let [moment, force] = child.times(child.drift);
        let force = axes.rotate(child.force + force);
        let moment = axes.rotate(child.moment + moment);
        self.force = self.force + force;
        self.moment = self.moment + (moment + origin.cross(force));
        let back = axes.transpose();
        let angular = axes.compose(&child.angular).compose(&back);
        let coupling = axes.compose(&child.coupling).compose(&back);
        let linear = axes.compose(&child.linear).compose(&back);
        let mut moved = coupling;
        for k in 0..3 {
            moved.0[k] = coupling.0[k] + origin.cross(linear.0[k]);
        }
        let back = moved.transpose();
        for (k, axis) in IDENTITY.into_iter().enumerate() {
            let lever = coupling.rotate(origin.cross(Vector::all(axis)));
            let arm = origin.cross(back.0[k]);
            self.angular.0[k] = self.angular.0[k] + ((angular.0[k] - lever) + arm);
            self.coupling.0[k] = self.coupling.0[k] + moved.0[k];
            self.linear.0[k] = self.linear.0[k] + linear.0[k];
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
        check_length("scratch", scratch.places.len(), links.len())?;
        check_length("a", a.len(), self.nv())?;
        let ground = Vector::all(self.parts().gravity);
        let (q, v, tau) = (q.as_chunks().0, v.as_chunks().0, tau.as_chunks().0);
        let rows = &self.tree.rows;
        let [singular] =
            accelerations(links, rows, ground, [q, v, tau], &mut scratch.forward, a.as_chunks_mut().0);
        self.check_accelerations(singular, a)
    }

    /// Refuses accelerations that are not finite, and those with a link that moves nothing with mass, unless
    /// it is the ground.
    pub(crate) fn check_accelerations(&self, singular: usize, a: &[f64]) -> Result<(), Error> {
        if singular != 0 {
            let expected = "above zero (mass on the bodies it moves, or armature)";
            let (field, index) = ("the inertia it moves", self.tree.links[singular].joint);
            return Err(Error::Part { kind: "joint", index, field, expected });
        }
        check_entries("a", a, self.nv())
    }

    /// Poses and velocities of all links, each in its own frame.
    pub(super) fn velocities(&self, q: &[f64], v: &[f64], scratch: &mut Scratch) {
        let Tree { links, rows, .. } = &self.tree;
        velocities(links, rows, q.as_chunks().0, v.as_chunks().0, &mut scratch.forward.links);
    }
}

#[inline(always)]
fn velocities<const N: usize>(
    links: &[Link],
    rows: &[LinkRows<N>],
    q: &[[f64; N]],
    v: &[[f64; N]],
    states: &mut [LinkState<N>],
) {
    for (index, (link, rows)) in links.iter().zip(rows).enumerate().skip(1) {
        let start = PoseRows { axes: rows.axes, origin: rows.origin };
        let PoseRows { axes, origin } = start.moved(link, rows.reference, q);
        let mut moving = [Vector::default(); 2];
        if link.parent != 0 {
            let parent = &states[link.parent];
            moving[0] = axes.unrotate(parent.omega);
            moving[1] = axes.unrotate(parent.velocity + parent.omega.cross(origin));
        }
        for k in 0..link.kind.velocities() {
            Way::new(link.kind, &axes, k).add(Row(v[link.v + k]), &mut moving);
        }
        let [omega, velocity] = moving;
        states[index] = LinkState { axes, origin, omega, velocity };
    }
}

/// [`Robot::forward_dynamics`] in several worlds: `[q, v, tau]` with the acceleration of gravity in each. The
/// first link of every world that moves nothing with mass, 0 where there is none.
#[inline(always)]
pub(crate) fn accelerations<const N: usize>(
    links: &[Link],
    rows: &[LinkRows<N>],
    gravity: Vector<N>,
    [q, v, tau]: [&[[f64; N]]; 3],
    scratch: &mut ForwardScratch<N>,
    a: &mut [[f64; N]],
) -> [usize; N] {
    velocities(links, rows, q, v, &mut scratch.links);
    for (index, (link, rows)) in links.iter().zip(rows).enumerate().skip(1) {
        let moving = &scratch.links[index];
        let mut own = ArticulatedBody::rigid(rows, moving.omega, moving.velocity);
        own.drift = drift(link, moving, v);
        scratch.bodies[index] = own;
    }
    let mut singular = [0; N];
    for (index, (link, rows)) in links.iter().zip(rows).enumerate().skip(1).rev() {
        let sound = inward(index, link, rows, tau, scratch);
        if !sound.all() {
            for (first, sound) in singular.iter_mut().zip(sound.0) {
                if sound == 0 && *first == 0 {
                    *first = index;
                }
            }
        }
    }
    for (index, link) in links.iter().enumerate().skip(1) {
        let parent = match link.parent {
            0 => [Vector::default(), Row::all(-1.0) * gravity],
            parent => scratch.bodies[parent].acceleration,
        };
        outward(link, parent, scratch, index, a);
    }
    singular
}

/// Eliminates the velocities of a link and adds what is left to its parent; the worlds in which it moves
/// something with mass.
#[inline(always)]
fn inward<const N: usize>(
    index: usize,
    link: &Link,
    rows: &LinkRows<N>,
    tau: &[[f64; N]],
    scratch: &mut ForwardScratch<N>,
) -> Mask<N> {
    let LinkState { axes, origin, .. } = scratch.links[index];
    let (before, rest) = scratch.bodies.split_at_mut(index);
    let own = &mut rest[0];
    let mut sound = !Mask::NONE;
    for k in 0..link.kind.velocities() {
        let way = Way::new(link.kind, &axes, k);
        let wrench = own.along(way);
        let pivot = way.of(&wrench) + rows.armature;
        let left = Row(tau[link.v + k]) - way.of(&[own.moment, own.force]);
        // Scale of rounding errors: the inertia of the link itself.
        let mut whole = Row::default();
        for column in &own.angular.0 {
            whole = whole + column[0].abs() + column[1].abs() + column[2].abs();
        }
        let whole = own.linear.0[0][0].abs() + whole;
        sound = sound & (1e-14 * whole).less(pivot) & Row::default().less(pivot);
        scratch.pivots[link.v + k] = [left, pivot];
        scratch.columns[link.v + k] = wrench;
        own.eliminate(wrench, pivot, left);
    }
    if link.parent != 0 {
        before[link.parent].add_child(own, &axes, origin);
    }
    sound
}

/// Velocity-product acceleration of a link relative to its parent.
#[inline(always)]
fn drift<const N: usize>(link: &Link, moving: &LinkState<N>, v: &[[f64; N]]) -> [Vector<N>; 2] {
    let (omega, velocity, none) = (moving.omega, moving.velocity, Row::default());
    let rate = |k: usize| Row(v[link.v + k]);
    match link.kind {
        JointKind::Hinge => {
            let across = |a: Vector<N>| Vector([a[1] * rate(0), -(a[0] * rate(0)), none]);
            [across(omega), across(velocity)]
        }
        JointKind::Slide => [Vector::default(), Vector([omega[1] * rate(0), -(omega[0] * rate(0)), none])],
        JointKind::Ball => {
            let turn = Vector([rate(0), rate(1), rate(2)]);
            [omega.cross(turn), velocity.cross(turn)]
        }
        JointKind::Free => [Vector::default(), (Row::all(-1.0) * omega).cross(velocity)],
    }
}

#[inline(always)]
fn outward<const N: usize>(
    link: &Link,
    [alpha, linear]: [Vector<N>; 2],
    scratch: &mut ForwardScratch<N>,
    index: usize,
    a: &mut [[f64; N]],
) {
    let moving = &scratch.links[index];
    let own = &mut scratch.bodies[index];
    let carried = linear + alpha.cross(moving.origin);
    let [turn, shift] = own.drift;
    let mut motion = [moving.axes.unrotate(alpha) + turn, moving.axes.unrotate(carried) + shift];
    for k in (0..link.kind.velocities()).rev() {
        let [left, pivot] = scratch.pivots[link.v + k];
        let [moment, force] = scratch.columns[link.v + k];
        let one = (left - (moment.dot(motion[0]) + force.dot(motion[1]))) / pivot;
        Way::new(link.kind, &moving.axes, k).add(one, &mut motion);
        a[link.v + k] = one.0;
    }
    own.acceleration = motion;
}
