use super::link::{Inertia, Link};
use super::parts::JointKind;
use super::robot::Robot;
use super::scratch::Scratch;
use super::vector::{
    Frame, IDENTITY, Vector, add, add_scaled, cross, dot, point_inertia, rotate, rotate_symmetric, symmetric,
    unrotate,
};
use crate::error::{Error, check_entries, check_length};

impl Link {
    /// Motion per unit of the link's `k`th velocity, in its own frame: angular, and linear of its origin.
    #[inline]
    pub(super) fn subspace(&self, axes: &Frame, k: usize) -> (Vector, Vector) {
        const NONE: Vector = [0.0; 3];
        match self.kind {
            JointKind::Hinge => (IDENTITY[2], NONE),
            JointKind::Slide => (NONE, IDENTITY[2]),
            JointKind::Ball => (IDENTITY[k], NONE),
            JointKind::Free if k < 3 => (NONE, unrotate(axes, IDENTITY[k])),
            JointKind::Free => (IDENTITY[k - 3], NONE),
        }
    }
}

impl Inertia {
    /// The same inertia in the frame in which `axes` and `origin` are given.
    fn in_parent(&self, axes: &Frame, origin: Vector) -> Inertia {
        let moment = rotate(axes, self.moment);
        let mut about_origin = rotate_symmetric(axes, &self.about_origin);
        let [x, y, z] = origin;
        let [a, b, c] = moment;
        let both = 2.0 * dot(origin, moment);
        let mixed = [
            both - 2.0 * x * a,
            both - 2.0 * y * b,
            both - 2.0 * z * c,
            -x * b - y * a,
            -x * c - z * a,
            -y * c - z * b,
        ];
        for (entry, extra) in about_origin.iter_mut().zip(mixed.iter().zip(point_inertia(self.mass, origin)))
        {
            *entry += extra.0 + extra.1;
        }
        Inertia { mass: self.mass, moment: add_scaled(moment, self.mass, origin), about_origin }
    }

    /// Inertia times acceleration: moment about the origin and force.
    #[inline]
    fn times(&self, turn: Vector, shift: Vector) -> (Vector, Vector) {
        let moment = add(symmetric(&self.about_origin, turn), cross(self.moment, shift));
        (moment, add_scaled(cross(turn, self.moment), self.mass, shift))
    }
}

impl Robot {
    /// The mass matrix, armature included.
    ///
    /// ```text
    /// M(q): kinetic energy = v^T M v / 2;   tau = M a + c + g
    /// ```
    ///
    /// # Shapes
    /// `q: [nq]`, `mass: [nv x nv]`, row by row, symmetric.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    ///
    /// # Source
    /// `featherstone2008`, table 6.2.
    #[doc(alias = "crba")]
    pub fn mass_matrix(&self, q: &[f64], scratch: &mut Scratch, mass: &mut [f64]) -> Result<(), Error> {
        self.check_coordinates(q)?;
        let (links, nv) = (&self.tree.links, self.nv());
        check_length("scratch", scratch.places.len(), links.len())?;
        check_length("mass", mass.len(), nv * nv)?;
        mass.fill(0.0);
        for (index, link) in links.iter().enumerate().skip(1) {
            scratch.places[index] = link.pose_in_parent(q);
            scratch.composite[index] = link.inertia;
        }
        for (index, link) in links.iter().enumerate().skip(1).rev() {
            let composite = scratch.composite[index];
            if link.parent != 0 {
                let (axes, origin) = &scratch.places[index];
                let transformed = composite.in_parent(axes, *origin);
                scratch.composite[link.parent].add(&transformed);
            }
            for k in 0..link.kind.velocities() {
                self.column(index, k, &composite, scratch, mass);
            }
        }
        check_entries("mass", mass, nv * nv)
    }

    /// Row and column of one velocity: the wrench of the composite body, projected on all joints toward the
    /// ground.
    fn column(&self, index: usize, k: usize, composite: &Inertia, scratch: &Scratch, mass: &mut [f64]) {
        let (links, nv) = (&self.tree.links, self.nv());
        let link = &links[index];
        let own = link.v + k;
        let (turn, shift) = link.subspace(&scratch.places[index].0, k);
        let (mut moment, mut force) = composite.times(turn, shift);
        let (mut at, mut count) = (index, k + 1);
        while at != 0 {
            let (here, (axes, origin)) = (&links[at], &scratch.places[at]);
            for other in 0..count {
                let (turn, shift) = here.subspace(axes, other);
                let entry = dot(turn, moment) + dot(shift, force);
                mass[own * nv + here.v + other] = entry;
                mass[(here.v + other) * nv + own] = entry;
            }
            force = rotate(axes, force);
            moment = add(rotate(axes, moment), cross(*origin, force));
            at = here.parent;
            count = links[at].kind.velocities();
        }
        mass[own * nv + own] += link.armature;
    }
}
