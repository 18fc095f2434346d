use super::Poses;
use super::parts::{Joint, JointKind};
use super::robot::Robot;
use super::scratch::Scratch;
use super::vector::{
    add, add_scaled, cross, dot, product, quaternion_product, rotation_of, symmetric, unit_quaternion,
};
use crate::error::{Error, check_entries, check_length};
use crate::lanes::Row;

/// Spring and damper of a joint in several worlds.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointSpring<const N: usize> {
    stiffness: Row<N>,
    damping: Row<N>,
    reference: Row<N>,
}

impl<const N: usize> JointSpring<N> {
    /// Takes that of another world as world `k`.
    pub(crate) fn set(&mut self, k: usize, one: &JointSpring<1>) {
        self.stiffness.0[k] = one.stiffness.0[0];
        (self.damping.0[k], self.reference.0[k]) = (one.damping.0[0], one.reference.0[0]);
    }

    /// Deflection of a hinge or slide.
    #[inline(always)]
    pub(crate) fn stretch(&self, q: Row<N>) -> Row<N> {
        q - self.reference
    }

    /// Force along a velocity.
    #[inline(always)]
    pub(crate) fn force(&self, stretch: Row<N>, v: Row<N>) -> Row<N> {
        -self.stiffness * stretch - self.damping * v
    }
}

impl From<&Joint> for JointSpring<1> {
    fn from(joint: &Joint) -> Self {
        let [stiffness, damping] = [joint.stiffness, joint.damping].map(Row::all);
        Self { stiffness, damping, reference: Row::all(joint.spring_reference) }
    }
}

impl Robot {
    /// Kinetic energy `v^T M v / 2`, armature included, J.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn kinetic_energy(&self, q: &[f64], v: &[f64], scratch: &mut Scratch) -> Result<f64, Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        check_length("scratch", scratch.places.len(), self.tree.links.len())?;
        self.velocities(q, v, scratch);
        let mut twice = 0.0;
        for (index, link) in self.tree.links.iter().enumerate().skip(1) {
            let (moving, body) = (&scratch.forward.links[index], &link.inertia);
            let (omega, velocity) = (moving.omega.at(0), moving.velocity.at(0));
            let momentum = add_scaled(cross(omega, body.moment), body.mass, velocity);
            let spin = add(symmetric(&body.about_origin, omega), cross(body.moment, velocity));
            twice += dot(velocity, momentum) + dot(omega, spin);
            let rates = &v[link.v..link.v + link.kind.velocities()];
            twice += link.armature * product(rates, rates);
        }
        Ok(0.5 * twice)
    }

    /// Potential energy of gravity (zero for mass at the world's origin; of what is
    /// [not held](Robot::gravity_compensation)) and of the joints' springs, J.
    ///
    /// # Errors
    /// [`Error::WrongLength`] where poses of another robot are given.
    pub fn potential_energy(&self, q: &[f64], poses: &Poses) -> Result<f64, Error> {
        self.check_coordinates(q)?;
        check_length("poses", poses.links.len(), self.tree.links.len())?;
        let gravity = self.parts().gravity;
        let mut energy = 0.0;
        for (index, link) in self.tree.links.iter().enumerate().skip(1) {
            let pose = &poses.links[index];
            let (mass, moment) = link.weighing();
            let lever = super::vector::rotate(&pose.axes, moment);
            energy -= dot(gravity, add_scaled(lever, mass, pose.origin));
            let joint = &self.parts().joints[link.joint];
            let mut stretch = [0.0; 6];
            self.stretch(link.joint, q, &mut stretch);
            energy += 0.5 * joint.stiffness * product(&stretch, &stretch);
        }
        Ok(energy)
    }

    /// Forces of the joints' springs and dampers. MuJoCo's `qfrc_passive` without tendons
    /// and without [what holds bodies](Robot::gravity_compensation).
    ///
    /// ```text
    /// tau = -k (q - q_s) - d v
    /// ```
    ///
    /// The spring of a ball joint acts along the rotation vector to its reference.
    ///
    /// # Shapes
    /// `q: [nq]`, `v` and `tau: [nv]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn passive_force(&self, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        check_length("tau", tau.len(), self.nv())?;
        for link in self.moving_links() {
            let joint = &self.parts().joints[link.joint];
            let mut stretch = [0.0; 6];
            self.stretch(link.joint, q, &mut stretch);
            for (k, stretch) in stretch.into_iter().enumerate().take(link.kind.velocities()) {
                tau[link.v + k] = JointSpring::from(joint).force(Row([stretch]), Row([v[link.v + k]])).0[0];
            }
        }
        check_entries("tau", tau, self.nv())
    }

    /// Deflection of a joint's spring along each of its velocities.
    fn stretch(&self, joint: usize, q: &[f64], out: &mut [f64; 6]) {
        let q = &q[self.coordinates_of(joint)];
        let part = &self.parts().joints[joint];
        let turn = |q: &[f64], rest: [f64; 4]| {
            let now = unit_quaternion([q[0], q[1], q[2], q[3]]);
            let back = [rest[0], -rest[1], -rest[2], -rest[3]];
            rotation_of(quaternion_product(back, now))
        };
        match part.kind {
            JointKind::Hinge | JointKind::Slide => {
                out[0] = JointSpring::from(part).stretch(Row([q[0]])).0[0];
            }
            JointKind::Ball => out[..3].copy_from_slice(&turn(q, [1.0, 0.0, 0.0, 0.0])),
            JointKind::Free => {
                let body = &self.parts().bodies[part.body];
                for k in 0..3 {
                    out[k] = q[k] - body.position[k];
                }
                out[3..].copy_from_slice(&turn(&q[3..], body.orientation));
            }
        }
    }
}
