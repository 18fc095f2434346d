//! The tension that a body's muscles work with: against its weight, and a force at its ends.

use crate::Error;
use crate::body::{IndependentKinematics, Robot};
use crate::control::tension::{Distribution, Problem, Status};
use crate::machine::Machine;
use crate::muscle::MuscleDynamics;
use crate::random::EvenPoints;
use crate::trajectory::{ControllableMotion, Equilibrium};
use alloc::vec;
use alloc::vec::Vec;

/// The tension that a machine's strongest muscle works with.
///
/// ```text
/// F(q) = argmin |F|^2,  R^T F = tau(q),  F >= 0;     tau = g(q)  and  g(q) +- J^T f e_x, e_y, e_z
/// F_w  = max(95 % quantile of max_k F with g alone,  90 % quantile with the force f)
/// ```
///
/// | symbol | code        | unit | meaning                                                             |
/// |--------|-------------|------|---------------------------------------------------------------------|
/// | q      |             |      | poses in the middle 60 % of the joints' ranges                       |
/// | f      | `tip_force` | N    | at the end point, else at the mass centre of every last body in turn |
///
/// Of a machine with fewer motors than joints: where springs and weight take the joints at the lengths
/// that the cables have in these poses, along what the cables control. Every muscle has such a tension of
/// its own, the same quantiles of its `F_k`. Quantiles: a moment arm that passes zero within the ranges
/// would ask for a crane.
///
/// # Source
/// Own addition.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkingTension {
    /// `F_w`, N, >= 0.
    pub tension: f64,
    /// `f`, N.
    pub tip_force: f64,
    /// The same of every muscle, N: `[muscles]`.
    pub own: Vec<f64>,
    /// The muscle with this tension.
    pub muscle: usize,
    /// The pose in which it has it: `[joints]`, rad or m.
    pub pose: Vec<f64>,
    /// Independent joint on which it pulls most there, and its moment arm, m.
    pub joint: (usize, f64),
}

/// Sampled poses.
const POSES: usize = 150;
/// Part of every range in which they are.
const MIDDLE: f64 = 0.6;
/// Quantiles without and with a force.
const ALONE: f64 = 0.95;
const LOADED: f64 = 0.9;
/// Fraction of the poses that the muscles hold with any tension at least.
const HELD: f64 = 0.5;
/// Force at the end where none is given: this fraction of the moving weight.
const OWN_WEIGHT: f64 = 0.5;
/// Of a body that is described without gravity, m/s^2.
const GRAVITY: f64 = 9.81;
/// Largest tension that is considered, N: none.
const MAX_TENSION: f64 = 1e6;

/// The tension that the muscles of a machine work with, with a force at its end of `tip_force`, N (half of
/// its moving weight where none is given); none where its muscles hold less than half of its poses.
///
/// # Errors
/// As [`MuscleDynamics::new`].
pub fn working_tension(machine: &Machine, tip_force: Option<f64>) -> Result<Option<WorkingTension>, Error> {
    let machine = &machine.loaded()?;
    let parts = machine.robot.parts();
    let gravity = libm::sqrt(parts.gravity.iter().map(|g| g * g).sum());
    let weight = machine.robot.moving_mass() * if gravity > 0.0 { gravity } else { GRAVITY };
    let tip_force = tip_force.unwrap_or(0.0).max(OWN_WEIGHT * weight);
    let mut held = Held::new(machine)?;
    let (mut alone, mut loaded) = (Vec::new(), Vec::new());
    let mut own = [vec![Vec::new(); held.most.len()], vec![Vec::new(); held.most.len()]];
    let ends = ends(machine);
    let ranges = machine.ranges()?;
    for point in EvenPoints::new(ranges.len()).take(POSES) {
        let within = |([low, high], x): (&[f64; 2], f64)| low + (0.5 + MIDDLE * (x - 0.5)) * (high - low);
        let mut pose: Vec<f64> = ranges.iter().zip(point).map(within).collect();
        let Some(torque) = held.evaluate(&mut pose)? else { continue };
        alone.extend(held.largest(&torque, &pose, &mut own[0])?);
        for (body, place) in &ends {
            let rows = held.jacobian(*body, *place)?.to_vec();
            let n = torque.len();
            for (row, sign) in (0..3).flat_map(|row| [(row, 1.0), (row, -1.0)]) {
                let pulled = (0..n).map(|j| torque[j] + sign * tip_force * rows[row * n + j]);
                let pulled: Vec<f64> = pulled.collect();
                loaded.extend(held.largest(&pulled, &pose, &mut own[1])?);
            }
        }
    }
    if (alone.len() as f64) < HELD * POSES as f64 {
        return Ok(None);
    }
    let most =
        [quantile(alone, ALONE, tension_of), quantile(loaded, LOADED, tension_of)].into_iter().flatten();
    let most = most.reduce(|a, b| if b.tension > a.tension { b } else { a });
    let [alone, loaded] = own;
    let own = alone.into_iter().zip(loaded).map(|(alone, loaded)| {
        let most = [quantile(alone, ALONE, |f| *f), quantile(loaded, LOADED, |f| *f)];
        most.into_iter().flatten().fold(0.0, f64::max)
    });
    let own = own.collect();
    Ok(most.map(|found| WorkingTension { tip_force, own, ..found }))
}

fn tension_of(found: &WorkingTension) -> f64 {
    found.tension
}

/// The one below which a fraction of them has its tension.
fn quantile<T>(mut found: Vec<T>, fraction: f64, tension: fn(&T) -> f64) -> Option<T> {
    found.sort_by(|a, b| tension(a).total_cmp(&tension(b)));
    let index = libm::ceil(fraction * found.len() as f64) as usize;
    (!found.is_empty()).then(|| found.swap_remove(index.saturating_sub(1)))
}

/// Bodies and points at which a force is considered, m from the body: the end point of the machine, else the
/// mass centre of every body that moves and carries no other.
fn ends(machine: &Machine) -> Vec<(usize, [f64; 3])> {
    let parts = machine.robot.parts();
    if let Some(site) = machine.payload_site() {
        return vec![(parts.sites[site].body, parts.sites[site].position)];
    }
    let moves = |mut body: usize| {
        while body != 0 && parts.joints.iter().all(|joint| joint.body != body) {
            body = parts.bodies[body].parent;
        }
        body != 0
    };
    let carries = |body: usize| parts.bodies.iter().skip(1).any(|other| other.parent == body);
    let last = (1..parts.bodies.len()).filter(|body| moves(*body) && !carries(*body));
    last.map(|body| (body, parts.bodies[body].center_of_mass)).collect()
}

/// A pose held by tensions alone.
struct Held {
    robot: Robot,
    equilibrium: Option<Equilibrium>,
    dynamics: MuscleDynamics,
    kinematics: IndependentKinematics,
    distribution: Distribution,
    zeros: Vec<f64>,
    ones: Vec<f64>,
    most: Vec<f64>,
}

impl Held {
    fn new(machine: &Machine) -> Result<Self, Error> {
        let equilibrium = Equilibrium::new(&machine.robot)?;
        let controlled = equilibrium.as_ref().map(|found| found.motion().count());
        let (m, n) = (machine.muscles.len(), controlled.unwrap_or(machine.encoders.len()));
        Ok(Self {
            equilibrium,
            dynamics: MuscleDynamics::new(&machine.robot)?,
            kinematics: IndependentKinematics::new(&machine.robot),
            distribution: Distribution::new(m, n),
            zeros: vec![0.0; m],
            ones: vec![1.0; m],
            most: vec![MAX_TENSION; m],
            robot: machine.robot.clone(),
        })
    }

    /// Torque that holds the pose, or that to which it settles, Nm or N: `[joints]`; none where it snaps.
    fn evaluate(&mut self, pose: &mut [f64]) -> Result<Option<Vec<f64>>, Error> {
        if let Some(equilibrium) = &mut self.equilibrium
            && equilibrium.settle(pose)?.is_some()
        {
            return Ok(None);
        }
        self.dynamics.evaluate(pose)?;
        self.kinematics.evaluate(&self.robot, pose)?;
        let rest = vec![0.0; pose.len()];
        let mut torque = vec![0.0; pose.len()];
        self.dynamics.inverse_dynamics(&rest, &rest, &mut torque)?;
        Ok(Some(torque))
    }

    /// Of a point of a body by the independent joints: `[3 x joints]`.
    fn jacobian(&mut self, body: usize, point: [f64; 3]) -> Result<&[f64], Error> {
        let at = self.robot.body_pose(&self.kinematics.poses, body).point(point);
        self.kinematics.point(&self.robot, body, at)?;
        Ok(&self.kinematics.rows)
    }

    /// The largest of the minimum tensions for a torque; none where no tensions give it. All are added to
    /// `own`.
    fn largest(
        &mut self,
        torque: &[f64],
        pose: &[f64],
        own: &mut [Vec<f64>],
    ) -> Result<Option<WorkingTension>, Error> {
        let moment_arms = self.dynamics.moment_arms();
        let motion = self.equilibrium.as_ref().map(Equilibrium::motion);
        let mut along = vec![0.0; motion.map_or(0, ControllableMotion::count)];
        if let Some(motion) = motion {
            motion.torque(torque, &mut along);
        }
        let solution = self.distribution.solve(&Problem {
            moment_arms: motion.map_or(moment_arms, ControllableMotion::arms),
            torque: if motion.is_some() { &along } else { torque },
            minimum: &self.zeros,
            maximum: &self.most,
            reference: &self.zeros,
            weight: &self.ones,
        })?;
        let tensions = solution.tension.iter().copied().enumerate();
        let Some((muscle, tension)) = tensions.max_by(|a, b| a.1.total_cmp(&b.1)) else { return Ok(None) };
        if solution.status != Status::Optimal {
            return Ok(None);
        }
        own.iter_mut().zip(solution.tension).for_each(|(own, tension)| own.push(*tension));
        let n = pose.len();
        let arms = moment_arms[muscle * n..(muscle + 1) * n].iter().copied().enumerate();
        let joint = arms.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or_default();
        Ok(Some(WorkingTension {
            tension,
            tip_force: 0.0,
            own: Vec::new(),
            muscle,
            pose: pose.to_vec(),
            joint,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tests::{Slide, slides};

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    /// Weights on each other, 2 kg each.
    fn machine(gravity: f64, joints: usize, arms: &[&[f64]]) -> Machine {
        let all: Vec<Slide> =
            (0..joints).map(|_| Slide { axis: UP, mass: 2.0, range: [-0.1, 0.1] }).collect();
        Machine::from_robot(&slides(gravity, &all, arms)).unwrap()
    }

    #[test]
    fn a_weight_works_with_half_of_itself_more_or_with_a_larger_force() {
        let machine = machine(9.81, 1, &[&[1.0], &[-1.0]]);
        let weight = 2.0 * 9.81;
        for (force, expected) in
            [(None, 1.5 * weight), (Some(1.0), 1.5 * weight), (Some(50.0), 50.0 + weight)]
        {
            let found = working_tension(&machine, force).unwrap().unwrap();
            assert!((found.tension / expected - 1.0).abs() < 1e-9, "{} {expected}", found.tension);
            assert_eq!((found.muscle, found.joint), (0, (0, 1.0)), "the one that lifts");
            let lowers = (found.tension - 2.0 * weight).max(0.0);
            assert!((found.own[0] - found.tension).abs() < 1e-9 && (found.own[1] - lowers).abs() < 1e-9);
        }
    }

    #[test]
    fn a_moment_arm_of_half_the_length_works_with_twice_the_tension_and_is_named() {
        let machine = machine(9.81, 2, &[&[1.0, 0.0], &[-1.0, 0.0], &[0.0, 0.25], &[0.0, -0.25]]);
        let found = working_tension(&machine, None).unwrap().unwrap();
        // The upper one carries its own weight, and half of both.
        assert!((found.tension / (4.0 * 2.0 * 2.0 * 9.81) - 1.0).abs() < 1e-9, "{}", found.tension);
        assert_eq!((found.muscle, found.joint), (2, (1, 0.25)));
        assert_eq!(found.pose.len(), 2);
    }

    #[test]
    fn without_gravity_it_works_against_the_force_of_its_weight_on_earth() {
        let found = working_tension(&machine(0.0, 1, &[&[1.0], &[-1.0]]), None).unwrap().unwrap();
        assert!((found.tension / (0.5 * 2.0 * 9.81) - 1.0).abs() < 1e-9, "{}", found.tension);
    }

    #[test]
    fn muscles_that_hold_no_pose_have_none() {
        assert_eq!(working_tension(&machine(9.81, 1, &[&[-1.0]]), None).unwrap(), None);
    }
}
