use crate::Error;
use crate::body::{Robot, Scratch};
use crate::muscle::{Geometry, Muscles};
use alloc::vec;
use alloc::vec::Vec;

/// The controller's model of the body: geometry of the muscles and dynamics of the joints, one pose at a
/// time.
#[derive(Debug, Clone)]
pub(super) struct BodyModel {
    robot: Robot,
    muscles: Muscles,
    geometry: Geometry,
    scratch: Scratch,
    /// `R`, m: `[muscles x joints]`, row-major.
    pub(super) moment_arms: Vec<f64>,
    /// `phi(q)`, wrap angle of every muscle at its joints, rad: `[muscles]`.
    pub(super) wrap_angles: Vec<f64>,
    passive: Vec<f64>,
    torque: Vec<f64>,
}

impl BodyModel {
    pub(super) fn new(robot: &Robot) -> Self {
        let muscles = Muscles::new(robot);
        Self {
            geometry: Geometry::new(robot, &muscles),
            scratch: Scratch::new(robot),
            moment_arms: vec![0.0; muscles.count() * robot.nv()],
            wrap_angles: vec![0.0; muscles.count()],
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

    /// Lengths (19), moment arms `R = -dl/dq` (20) and wrap angles in a pose.
    pub(super) fn evaluate_geometry(&mut self, q: &[f64]) -> Result<(), Error> {
        self.muscles.evaluate(q, &mut self.geometry)?;
        self.muscles.dense(&self.geometry, &mut self.moment_arms)?;
        self.muscles.bends(&self.geometry, &mut self.wrap_angles)
    }

    /// Root mean square of the moment arms of the muscles that cross a joint, m.
    pub(super) fn mean_arm(&self, joint: usize) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        for row in self.moment_arms.chunks_exact(self.joints()).filter(|row| row[joint] != 0.0) {
            squares += row[joint] * row[joint];
            count += 1.0;
        }
        libm::sqrt(squares / f64::max(count, 1.0))
    }

    /// Length of every muscle in the evaluated pose, m.
    pub(super) fn lengths(&self) -> &[f64] {
        self.geometry.lengths()
    }

    /// `R v = -l'`: speed of every anchor toward its motor, m/s, from joint velocities; displacement, m, from
    /// small changes of the joint angles. (20)
    pub(super) fn anchor_motion(&self, v: &[f64], out: &mut [f64]) {
        for (row, out) in self.moment_arms.chunks_exact(v.len()).zip(out) {
            *out = row.iter().zip(v).map(|(arm, v)| arm * v).sum();
        }
    }

    /// `M^-1 (R^T F - c - g + passive)`: acceleration under tensions at the anchors, (21) and (23) with `d =
    /// 0`.
    pub(super) fn forward_dynamics(
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

    /// `tau = M a + c + g - passive`: torque that the muscles have to give for an acceleration, (23).
    pub(super) fn inverse_dynamics(
        &mut self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.robot.inverse_dynamics(q, v, a, &mut self.scratch, out)?;
        self.robot.passive_force(q, v, &mut self.passive)?;
        out.iter_mut().zip(&self.passive).for_each(|(torque, passive)| *torque -= passive);
        Ok(())
    }
}
