use crate::Error;
use crate::body::{JointKind, Poses, Robot, Scratch, cholesky};
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Stiffness of the stops of a hinge, Nm/rad, and of a slide, N/m; assumed: rubber on a short lever.
const STOP_STIFFNESS: [f64; 2] = [300.0, 3e5];
/// Largest product of step and natural frequency of a joint on its stops, 1.
const STOP_STEP_ANGLE: f64 = 0.5;
/// `zeta_s`, damping ratio of the same, 1.
const STOP_DAMPING: f64 = 0.3;

/// The rigid bodies of a machine under cable tensions, in the coordinates of its independent joints.
///
/// ```text
/// M v' = R^T T_out - c - g - damping - stops
/// v <- v + h v',   q <- q + h v                    semi-implicit
/// stop:  -k x - 2 zeta_s sqrt(k I) v,   x beyond the range,   k = min(k_s, I (0.5/h)^2),   I = 1/(M^-1)_jj at the start
/// ```
///
/// A cable whose far end sticks is a spring on the joint's inertia. Semi-implicit steps are stable up to 2/h
/// and conserve energy in the mean; [`ArmSpecimen`](super::ArmSpecimen) chooses their number. A light joint
/// has softer stops, whose mode these steps integrate, too.
#[derive(Debug, Clone)]
pub(super) struct Limb {
    model: MuscleDynamics,
    scratch: Scratch,
    poses: Poses,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    a: Vec<f64>,
    stop_force: Vec<f64>,
    stops: Vec<Option<Stop>>,
    /// Forces from outside at the joints, Nm or N.
    pub(super) push: Vec<f64>,
}

/// The stops of a joint.
#[derive(Debug, Clone, Copy)]
struct Stop {
    /// rad or m.
    range: [f64; 2],
    /// Nm/rad or N/m.
    stiffness: f64,
    /// Nm s/rad or N s/m.
    damping: f64,
}

impl Limb {
    /// At rest with these coordinates of the independent joints, for steps of `h` s.
    pub(super) fn new(robot: &Robot, q: &[f64], h: f64) -> Result<Self, Error> {
        let mut model = MuscleDynamics::new(robot)?;
        let n = model.joints();
        model.evaluate(q)?;
        let mut factor = vec![0.0; n * n];
        model.mass_matrix(&mut factor)?;
        cholesky::factor(&mut factor, n)?;
        let joints = robot.independent_joints();
        let stop = |(j, joint): (usize, usize)| {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            cholesky::solve_lower(&factor, &mut unit);
            let inertia = 1.0 / unit.iter().map(|x| x * x).sum::<f64>();
            let joint = &robot.parts().joints[joint];
            let firm = STOP_STIFFNESS[usize::from(joint.kind == JointKind::Slide)];
            let stiffness = firm.min(inertia * (STOP_STEP_ANGLE / h) * (STOP_STEP_ANGLE / h));
            let damping = 2.0 * STOP_DAMPING * libm::sqrt(stiffness * inertia);
            joint.range.map(|range| Stop { range, stiffness, damping })
        };
        Ok(Self {
            scratch: Scratch::new(robot),
            poses: Poses::new(robot),
            q: q.to_vec(),
            v: vec![0.0; n],
            a: vec![0.0; n],
            stop_force: vec![0.0; n],
            push: vec![0.0; n],
            stops: joints.into_iter().enumerate().map(stop).collect(),
            model,
        })
    }

    pub(super) fn lengths(&self) -> &[f64] {
        self.model.lengths()
    }

    /// `phi(q)` of a muscle, rad.
    pub(super) fn bend(&self, muscle: usize) -> f64 {
        self.model.wrap_angle(muscle)
    }

    /// Advances by `h` seconds under these tensions at the anchors.
    pub(super) fn advance(&mut self, h: f64, tensions: &[f64]) -> Result<(), Error> {
        for (k, (force, stop)) in self.stop_force.iter_mut().zip(&self.stops).enumerate() {
            *force = stop.map_or(0.0, |stop| stop.force(self.q[k], self.v[k])) + self.push[k];
        }
        self.model.forward_dynamics(&self.v, tensions, Some(&self.stop_force), &mut self.a)?;
        for ((q, v), a) in self.q.iter_mut().zip(&mut self.v).zip(&self.a) {
            *v += h * a;
            *q += h * *v;
        }
        self.model.evaluate(&self.q)
    }

    /// Kinetic, potential and elastic energy of the stops, J.
    pub(super) fn energy(&mut self) -> Result<f64, Error> {
        let stops = self.stops.iter().flatten().zip(&self.q);
        let pressed: f64 =
            stops.map(|(stop, q)| 0.5 * stop.stiffness * stop.beyond(*q) * stop.beyond(*q)).sum();
        // The forces of a step expand the velocities of coupled joints.
        self.model.forward_dynamics(&self.v, &vec![0.0; self.model.muscles()], None, &mut self.a)?;
        let (robot, q) = (self.model.robot(), self.model.coordinates());
        robot.forward_kinematics(q, &mut self.poses)?;
        let height = robot.potential_energy(q, &self.poses)?;
        Ok(robot.kinetic_energy(q, self.model.velocities(), &mut self.scratch)? + height + pressed)
    }
}

impl Stop {
    /// Signed penetration.
    fn beyond(&self, q: f64) -> f64 {
        let [low, high] = self.range;
        (q - high).max(0.0) + (q - low).min(0.0)
    }

    /// A unilateral spring and damper.
    fn force(&self, q: f64, v: f64) -> f64 {
        let x = self.beyond(q);
        let push = -self.stiffness * x - self.damping * v;
        if x > 0.0 {
            push.min(0.0)
        } else if x < 0.0 {
            push.max(0.0)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_of_a_stop_is_unilateral() {
        let stop = Stop { range: [-1.0, 2.0], stiffness: 300.0, damping: 0.2 };
        assert!(stop.force(2.1, 0.0) < 0.0 && stop.force(-1.1, 0.0) > 0.0);
        assert!(stop.force(2.001, -50.0).abs() < 1e-12 && stop.force(0.0, 9.0).abs() < 1e-12);
    }
}
