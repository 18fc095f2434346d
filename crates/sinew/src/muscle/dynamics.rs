use super::sparse_arms::SparseArms;
use super::spring::Spring;
use super::worlds::MuscleWorlds;
use crate::body::{Reduction, Robot, Scratch};
use crate::error::{Error, check_entries, check_length};
use crate::lanes::Row;
use alloc::vec;
use alloc::vec::Vec;

/// Geometry of the muscles and dynamics of the joints in one pose, in the coordinates of the independent
/// joints.
///
/// ```text
/// M u' + c + g = R^T F + tau_p + tau_e,      R = -dl/du,      x' = R u
/// ```
///
/// | symbol | code                        | shape               | unit            | meaning                      |
/// |--------|-----------------------------|---------------------|-----------------|------------------------------|
/// | u      | `v`                         | `[joints]`          | rad/s, m/s      | velocities of the independent joints |
/// | R, l   | [`moment_arms`](Self::moment_arms), [`lengths`](Self::lengths) | `[muscles x joints]`, `[muscles]` | m, m | moment arms, lengths |
/// | F      | `tension`                   | `[muscles]`         | N               | tensions at the anchors       |
/// | tau_p, tau_e | , `external`          | `[joints]`          | Nm, N           | springs and dampers of joints and tendons; other forces |
/// | x      |                             | `[muscles]`         | m               | position of the anchors, + toward the motor |
///
/// Coupled joints follow ([`Reduction`]); without couplings all joints are independent.
///
/// # Source
/// `yuan2023`, eqs. 19 to 21 and 23.
#[derive(Debug, Clone)]
pub struct MuscleDynamics {
    robot: Robot,
    worlds: MuscleWorlds<1>,
    scratch: Scratch,
    /// None where no joint is coupled.
    reduction: Option<Reduction>,
    /// Index of every independent joint among all coordinates.
    independent: Vec<usize>,
    /// `R` without the entries that are always zero, and whole.
    arms: SparseArms,
    moment_arms: Vec<f64>,
    /// Of all joints: coordinates, velocities, accelerations, forces.
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    torque: Vec<f64>,
    /// Zeros, one for each independent joint.
    rest: Vec<f64>,
}

/// A spring of a tendon in a pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ActingSpring {
    /// Its place among the muscles and, behind them, the springs: that of its
    /// [`crossings`](MuscleDynamics::crossings).
    pub(crate) cable: usize,
    /// N/m.
    pub(crate) stiffness: f64,
    /// N s/m.
    pub(crate) damping: f64,
    /// Length beyond its slack, m; 0 where it is slack.
    pub(crate) stretch: f64,
}

impl MuscleDynamics {
    /// Of a robot with hinges and slides.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for ball and free joints.
    pub fn new(robot: &Robot) -> Result<Self, Error> {
        let (nq, nv) = (robot.nq(), robot.nv());
        crate::error::within("joints", "hinges and slides", nq as f64, nq == nv)?;
        let worlds = MuscleWorlds::new(robot);
        let coupled = !robot.parts().couplings.is_empty();
        let joints = robot.independent_joints();
        let independent: Vec<usize> =
            joints.into_iter().map(|joint| robot.velocities_of(joint).start).collect();
        let (m, n) = (worlds.topology.muscles, independent.len());
        let reduction = coupled.then(|| Reduction::new(robot));
        let leader = |velocity| reduction.as_ref().map_or(Some(velocity), |all| all.leader(velocity));
        Ok(Self {
            scratch: Scratch::new(robot),
            arms: SparseArms::new(&worlds.topology, leader),
            reduction,
            moment_arms: vec![0.0; m * n],
            q: robot.reference_pose(),
            v: vec![0.0; nv],
            a: vec![0.0; nv],
            torque: vec![0.0; nv],
            rest: vec![0.0; n],
            independent,
            worlds,
            robot: robot.clone(),
        })
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Number of muscles.
    #[must_use]
    pub fn muscles(&self) -> usize {
        self.worlds.topology.muscles
    }

    /// Number of independent joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.independent.len()
    }

    /// Index of every independent joint among all coordinates: `[joints]`.
    #[must_use]
    pub fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// All coordinates of the evaluated pose, rad or m: `[nq]`.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.q
    }

    /// All velocities of those that were used last, per s: `[nv]`.
    #[must_use]
    pub fn velocities(&self) -> &[f64] {
        &self.v
    }

    /// Length of every muscle in the evaluated pose, m: `[muscles]`.
    #[must_use]
    pub fn lengths(&self) -> &[f64] {
        &self.worlds.geometry.lengths()[..self.muscles()]
    }

    /// `R` in the evaluated pose, m, row by row: `[muscles x joints]`.
    #[must_use]
    pub fn moment_arms(&self) -> &[f64] {
        &self.moment_arms
    }

    /// `phi`, wrap angle of a muscle at its joints in the evaluated pose, rad; 0 for an index out of range.
    #[must_use]
    pub fn wrap_angle(&self, muscle: usize) -> f64 {
        if muscle < self.muscles() { self.worlds.bend(muscle).0[0] } else { 0.0 }
    }

    /// Sets the pose by the independent joints, rad or m: lengths (19), moment arms (20), wrap angles.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    pub fn evaluate(&mut self, u: &[f64]) -> Result<(), Error> {
        check_length("pose", u.len(), self.joints())?;
        for (&k, u) in self.independent.iter().zip(u) {
            self.q[k] = *u;
        }
        if self.reduction.is_some() {
            self.robot.apply_couplings(&mut self.q)?;
        }
        check_entries("q", &self.q, self.robot.nq())?;
        self.worlds.evaluate(self.q.as_chunks().0);
        let Self { worlds, .. } = self;
        check_entries("lengths", worlds.geometry.lengths(), worlds.topology.cables.len())?;
        check_entries("moment arms", worlds.geometry.moment_arms(), worlds.topology.columns.len())?;
        match &mut self.reduction {
            None => self.arms.gather(&self.worlds.geometry, |_| 1.0),
            Some(reduction) => {
                reduction.update(&self.robot, &self.q)?;
                self.arms.gather(&self.worlds.geometry, |velocity| reduction.slope(velocity));
            }
        }
        self.arms.spread(&mut self.moment_arms, self.independent.len());
        Ok(())
    }

    /// The joints that a muscle or a [spring](Self::springs) crosses, each with its moment arm, m: a row of
    /// `R` without the entries that are always zero.
    #[inline]
    pub(crate) fn crossings(&self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.arms.row(muscle)
    }

    /// `R u`: speed of every anchor toward its motor, m/s, from joint velocities; displacement, m, from
    /// small changes of the joints.
    pub fn anchor_motion(&self, v: &[f64], out: &mut [f64]) {
        for (muscle, out) in out.iter_mut().enumerate().take(self.muscles()) {
            *out = self.arms.row(muscle).map(|(joint, arm)| arm * v.get(joint).unwrap_or(&0.0)).sum();
        }
    }

    /// `M u' = R^T F + tau_p - c - g` in the evaluated pose: force that accelerates the joints under tensions
    /// at the anchors.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn accelerating_force(&mut self, v: &[f64], tension: &[f64], out: &mut [f64]) -> Result<(), Error> {
        check_entries("tension", tension, self.muscles())?;
        let rest = core::mem::take(&mut self.rest);
        let done = self.inverse_dynamics(v, &rest, out);
        self.rest = rest;
        done?;
        out.iter_mut().for_each(|force| *force = -*force);
        for (muscle, tension) in tension.iter().enumerate() {
            self.arms.row(muscle).for_each(|(joint, arm)| out[joint] += arm * tension);
        }
        Ok(())
    }

    /// `u'` in the evaluated pose under tensions at the anchors and external forces.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn forward_dynamics(
        &mut self,
        v: &[f64],
        tension: &[f64],
        external: Option<&[f64]>,
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.expand_velocities(v)?;
        check_entries("tensions", tension, self.muscles())?;
        let Self { robot, worlds, scratch, reduction, q, independent, .. } = self;
        check_entries("v", &self.v, robot.nv())?;
        let [q_row, v_row] = [&*q, &self.v].map(|entries| entries.as_chunks().0);
        worlds.forces(q_row, v_row, tension.as_chunks().0);
        if let Some(external) = external {
            let forces = worlds.torque.as_flattened_mut();
            independent.iter().zip(external).for_each(|(&k, external)| forces[k] += external);
        }
        check_entries("tau", worlds.torque.as_flattened(), robot.nv())?;
        match reduction {
            None => {
                check_length("a", out.len(), robot.nv())?;
                let [singular] = worlds.accelerations(q_row, v_row, out.as_chunks_mut().0);
                robot.check_accelerations(singular, out)
            }
            Some(reduction) => {
                reduction.forward_dynamics(robot, q, v, worlds.torque.as_flattened(), scratch, out)
            }
        }
    }

    /// `R^T F = M u' + c + g - tau_p` in the evaluated pose: force that the muscles have to give for an
    /// acceleration, (23).
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn inverse_dynamics(&mut self, v: &[f64], a: &[f64], out: &mut [f64]) -> Result<(), Error> {
        self.expand_velocities(v)?;
        let Self { robot, scratch, reduction, q, torque, worlds, .. } = self;
        check_entries("v", &self.v, robot.nv())?;
        worlds.passive(q.as_chunks().0, self.v.as_chunks().0);
        let passive = worlds.torque.as_flattened();
        match reduction {
            None => {
                robot.inverse_dynamics(q, v, a, scratch, out)?;
                out.iter_mut().zip(passive).for_each(|(torque, passive)| *torque -= passive);
                Ok(())
            }
            Some(reduction) => {
                reduction.accelerations(v, a, &mut self.a)?;
                robot.inverse_dynamics(q, &self.v, &self.a, scratch, torque)?;
                torque.iter_mut().zip(passive).for_each(|(torque, passive)| *torque -= passive);
                reduction.forces(torque, out)
            }
        }
    }

    /// Elastic energy of the springs of tendons in the evaluated pose, J.
    #[must_use]
    pub fn spring_energy(&self) -> f64 {
        let energy = |spring: &ActingSpring| 0.5 * spring.stiffness * spring.stretch * spring.stretch;
        self.springs().map(|spring| energy(&spring)).sum()
    }

    /// The springs of tendons in the evaluated pose.
    pub(crate) fn springs(&self) -> impl Iterator<Item = ActingSpring> {
        let MuscleWorlds { topology, numbers, geometry, .. } = &self.worlds;
        topology.springs.iter().zip(&numbers.springs).map(
            |(&Spring { cable, stiffness, damping, .. }, law)| {
                let stretch = law.stretch(Row(geometry.lengths[cable])).0[0];
                ActingSpring { cable, stiffness, damping, stretch }
            },
        )
    }

    /// Index of an independent joint, stiffness and damping of every spring and damper of a joint along it,
    /// in the evaluated pose.
    pub(crate) fn joint_springs(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let joints = self.robot.parts().joints.iter().enumerate();
        let sprung = joints.filter(|(_, joint)| joint.stiffness > 0.0 || joint.damping > 0.0);
        sprung.flat_map(|(k, joint)| {
            self.robot.velocities_of(k).filter_map(|velocity| {
                let (place, slope) = match &self.reduction {
                    None => (velocity, 1.0),
                    Some(reduction) => (reduction.leader(velocity)?, reduction.slope(velocity)),
                };
                Some((place, slope * slope * joint.stiffness, slope * slope * joint.damping))
            })
        })
    }

    /// `M` in the evaluated pose, row by row: `[joints x joints]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`].
    pub fn mass_matrix(&mut self, out: &mut [f64]) -> Result<(), Error> {
        let Self { robot, scratch, reduction, q, .. } = self;
        match reduction {
            None => robot.mass_matrix(q, scratch, out),
            Some(reduction) => reduction.mass_matrix(robot, q, scratch, out),
        }
    }

    /// Geometry and dynamics over rows of one world; none where joints are coupled.
    pub(crate) fn worlds(&self) -> Option<&MuscleWorlds<1>> {
        self.reduction.is_none().then_some(&self.worlds)
    }

    fn expand_velocities(&mut self, v: &[f64]) -> Result<(), Error> {
        match &self.reduction {
            Some(reduction) => reduction.velocities(v, &mut self.v),
            None => {
                check_length("velocities", v.len(), self.v.len())?;
                self.v.copy_from_slice(v);
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_and_forward_dynamics_agree_with_and_without_couplings() {
        for coupled in [false, true] {
            let robot = crate::muscle::tests::robots::chain(coupled);
            let mut model = MuscleDynamics::new(&robot).unwrap();
            let n = model.joints();
            let value = |seed: usize, k: usize| 0.3 * libm::sin((seed * 7 + 3 * k) as f64);
            let list = |seed| (0..n).map(|k| value(seed, k)).collect::<Vec<_>>();
            let (u, v, a) = (list(1), list(2), list(3));
            let tension = [30.0, 45.0, 20.0];
            model.evaluate(&u).unwrap();
            let (mut needed, mut found) = (vec![0.0; n], vec![0.0; n]);
            model.inverse_dynamics(&v, &a, &mut needed).unwrap();
            // External forces are what the muscles do not give.
            let given = |j: usize| (0..3).map(|m| tension[m] * model.moment_arms()[m * n + j]).sum::<f64>();
            let external: Vec<f64> = (0..n).map(|j| needed[j] - given(j)).collect();
            model.forward_dynamics(&v, &tension, Some(&external), &mut found).unwrap();
            assert!(found.iter().zip(&a).all(|(f, a)| (f - a).abs() < 1e-9), "{coupled} {found:?} {a:?}");
            // Both give one force, M times the acceleration without external ones.
            let (mut force, mut mass) = (vec![0.0; n], vec![0.0; n * n]);
            model.forward_dynamics(&v, &tension, None, &mut found).unwrap();
            model.accelerating_force(&v, &tension, &mut force).unwrap();
            model.mass_matrix(&mut mass).unwrap();
            for (force, row) in force.iter().zip(mass.chunks_exact(n)) {
                let product: f64 = row.iter().zip(&found).map(|(mass, a)| mass * a).sum();
                assert!((force - product).abs() < 1e-12, "{coupled} {force} {product}");
            }
        }
    }

    #[test]
    fn all_velocities_are_the_rates_of_all_coordinates_with_and_without_couplings() {
        for coupled in [false, true] {
            let mut model = MuscleDynamics::new(&crate::muscle::tests::robots::chain(coupled)).unwrap();
            let n = model.joints();
            let (u, v): (Vec<f64>, Vec<f64>) =
                (0..n).map(|k| (0.2 + 0.1 * k as f64, 0.5 - 0.9 * k as f64)).unzip();
            model.evaluate(&u).unwrap();
            model.forward_dynamics(&v, &[1.0; 3], None, &mut vec![0.0; n]).unwrap();
            let found = model.velocities().to_vec();
            let mut at = |h: f64| {
                let moved: Vec<f64> = u.iter().zip(&v).map(|(u, v)| u + h * v).collect();
                model.evaluate(&moved).unwrap();
                model.coordinates().to_vec()
            };
            let (before, after) = (at(-1e-5), at(1e-5));
            assert_eq!(found.len(), 3);
            for ((found, before), after) in found.iter().zip(before).zip(after) {
                assert!((found - (after - before) / 2e-5).abs() < 3e-12, "{coupled}: {found}");
            }
        }
    }
}
