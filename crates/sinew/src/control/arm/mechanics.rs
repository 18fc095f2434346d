use crate::Error;
use crate::body::{Robot, Scratch};
use crate::muscle::{Geometry, Muscles};
use alloc::vec;
use alloc::vec::Vec;

/// The body as the controller believes it to be, looked at in one pose at a time.
#[derive(Debug, Clone)]
pub(super) struct Mechanics {
    robot: Robot,
    muscles: Muscles,
    geometry: Geometry,
    scratch: Scratch,
    /// `R`, `[muscles x joints]`, row by row, m.
    pub(super) arms: Vec<f64>,
    /// `phi(q)` of every muscle, rad.
    pub(super) bends: Vec<f64>,
    passive: Vec<f64>,
    torque: Vec<f64>,
}

impl Mechanics {
    pub(super) fn new(robot: &Robot) -> Self {
        let muscles = Muscles::new(robot);
        Self {
            geometry: Geometry::new(robot, &muscles),
            scratch: Scratch::new(robot),
            arms: vec![0.0; muscles.count() * robot.nv()],
            bends: vec![0.0; muscles.count()],
            passive: vec![0.0; robot.nv()],
            torque: vec![0.0; robot.nv()],
            muscles,
            robot: robot.clone(),
        }
    }

    pub(super) fn muscles(&self) -> usize {
        self.muscles.count()
    }

    pub(super) fn joints(&self) -> usize {
        self.robot.nv()
    }

    /// Lengths, moment arms and bends in a pose.
    pub(super) fn look(&mut self, q: &[f64]) -> Result<(), Error> {
        self.muscles.evaluate(q, &mut self.geometry)?;
        self.muscles.dense(&self.geometry, &mut self.arms)?;
        self.muscles.bends(&self.geometry, &mut self.bends)
    }

    /// Of every muscle in the pose looked at, m.
    pub(super) fn lengths(&self) -> &[f64] {
        self.geometry.lengths()
    }

    /// `R v`: how fast every anchor moves toward its motor, m/s, or how far for a small `v`.
    pub(super) fn toward_motor(&self, v: &[f64], out: &mut [f64]) {
        for (row, out) in self.arms.chunks_exact(v.len()).zip(out) {
            *out = row.iter().zip(v).map(|(arm, v)| arm * v).sum();
        }
    }

    /// `M^-1 (R^T T - c - g + passive)`: what these tensions at the anchors do.
    pub(super) fn acceleration(
        &mut self,
        q: &[f64],
        v: &[f64],
        tension: &[f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.muscles.torque(&self.geometry, tension, &mut self.torque)?;
        self.robot.passive_force(q, v, &mut self.passive)?;
        self.torque.iter_mut().zip(&self.passive).for_each(|(torque, passive)| *torque += passive);
        self.robot.forward_dynamics(q, v, &self.torque, &mut self.scratch, out)
    }

    /// `M a + c + g - passive`: what an acceleration needs of the muscles.
    pub(super) fn torque(&mut self, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) -> Result<(), Error> {
        self.robot.inverse_dynamics(q, v, a, &mut self.scratch, out)?;
        self.robot.passive_force(q, v, &mut self.passive)?;
        out.iter_mut().zip(&self.passive).for_each(|(torque, passive)| *torque -= passive);
        Ok(())
    }
}
