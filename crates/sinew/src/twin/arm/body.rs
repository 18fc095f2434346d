use crate::Error;
use crate::body::{Poses, Robot, Scratch};
use crate::error::within;
use crate::muscle::{Geometry, Muscles};
use alloc::vec;
use alloc::vec::Vec;

/// Stiffness of a joint's stops, Nm/rad; assumed: rubber on a short lever.
pub const STOP_STIFFNESS: f64 = 300.0;
/// Damping of a joint's stops, Nm s/rad.
const STOP_DAMPING: f64 = 0.2;

/// The rigid bodies of the arm under cable tensions.
///
/// ```text
/// M v' = R^T T_out - c - g - damping - stops
/// v <- v + h v',   q <- q + h v                    semi-implicit
/// ```
///
/// A sticking cable is a spring of about 40 N/mm at a moment arm of 13 mm: with the forearm's 4.5e-4 kg m^2
/// its natural frequency is 170 rad/s, that of two cables 250. Semi-implicit steps are stable up to 2/h, 4000
/// rad/s at half a millisecond, and conserve energy in the mean.
#[derive(Debug, Clone)]
pub(super) struct Limb {
    robot: Robot,
    muscles: Muscles,
    geometry: Geometry,
    scratch: Scratch,
    poses: Poses,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    a: Vec<f64>,
    torque: Vec<f64>,
    passive: Vec<f64>,
    /// Range of every velocity's coordinate, where it has stops.
    stops: Vec<Option<[f64; 2]>>,
}

impl Limb {
    pub(super) fn new(robot: &Robot, q: &[f64]) -> Result<Self, Error> {
        let plain = robot.nq() == robot.nv() && robot.parts().couplings.is_empty();
        within("joints", "hinges and slides, none of them coupled", robot.nq() as f64, plain)?;
        let muscles = Muscles::new(robot);
        let nv = robot.nv();
        let range = |k| robot.joint_of_velocity(k).and_then(|joint| robot.parts().joints[joint].range);
        let mut limb = Self {
            geometry: Geometry::new(robot, &muscles),
            scratch: Scratch::new(robot),
            poses: Poses::new(robot),
            muscles,
            q: q.to_vec(),
            v: vec![0.0; nv],
            a: vec![0.0; nv],
            torque: vec![0.0; nv],
            passive: vec![0.0; nv],
            stops: (0..nv).map(range).collect(),
            robot: robot.clone(),
        };
        limb.muscles.evaluate(q, &mut limb.geometry)?;
        Ok(limb)
    }

    pub(super) fn lengths(&self) -> &[f64] {
        self.geometry.lengths()
    }

    /// `phi(q)` of every muscle, rad.
    pub(super) fn bends(&self, bends: &mut [f64]) -> Result<(), Error> {
        self.muscles.bends(&self.geometry, bends)
    }

    /// Advances by `h` seconds under these tensions at the anchors.
    pub(super) fn advance(&mut self, h: f64, tensions: &[f64]) -> Result<(), Error> {
        self.muscles.torque(&self.geometry, tensions, &mut self.torque)?;
        self.robot.passive_force(&self.q, &self.v, &mut self.passive)?;
        let forces = self.torque.iter_mut().zip(&self.passive);
        for (k, (torque, passive)) in forces.enumerate() {
            *torque += passive + self.stops[k].map_or(0.0, |range| stop(range, self.q[k], self.v[k]));
        }
        self.robot.forward_dynamics(&self.q, &self.v, &self.torque, &mut self.scratch, &mut self.a)?;
        self.v.iter_mut().zip(&self.a).for_each(|(v, a)| *v += h * a);
        self.robot.integrate(&mut self.q, &self.v, h)?;
        self.muscles.evaluate(&self.q, &mut self.geometry)
    }

    /// Kinetic, potential and elastic energy of the stops, J.
    pub(super) fn energy(&mut self) -> Result<f64, Error> {
        self.robot.forward_kinematics(&self.q, &mut self.poses)?;
        let stops = self.stops.iter().zip(&self.q).filter_map(|(range, &q)| Some(beyond((*range)?, q)));
        let pressed: f64 = stops.map(|x| 0.5 * STOP_STIFFNESS * x * x).sum();
        let height = self.robot.potential_energy(&self.q, &self.poses)?;
        Ok(self.robot.kinetic_energy(&self.q, &self.v, &mut self.scratch)? + height + pressed)
    }
}

/// Signed penetration of a coordinate into its stops.
fn beyond([low, high]: [f64; 2], q: f64) -> f64 {
    (q - high).max(0.0) + (q - low).min(0.0)
}

/// A unilateral spring and damper.
fn stop(range: [f64; 2], q: f64, v: f64) -> f64 {
    let x = beyond(range, q);
    let push = -STOP_STIFFNESS * x - STOP_DAMPING * v;
    if x > 0.0 {
        push.min(0.0)
    } else if x < 0.0 {
        push.max(0.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_of_a_stop_is_unilateral() {
        let range = [-1.0, 2.0];
        assert!(stop(range, 2.1, 0.0) < 0.0 && stop(range, -1.1, 0.0) > 0.0);
        assert!(stop(range, 2.001, -50.0).abs() < 1e-12 && stop(range, 0.0, 9.0).abs() < 1e-12);
    }
}
