use super::{Poses, Reduction, Robot};
use crate::Error;
use alloc::vec;
use alloc::vec::Vec;

/// Kinematics of a robot of hinges and slides over its independent joints: the pose evaluated last, and
/// Jacobians of points in it. Nothing is allocated after construction.
#[derive(Debug, Clone)]
pub(crate) struct IndependentKinematics {
    reduction: Reduction,
    pub(crate) poses: Poses,
    /// All coordinates, rad or m: `[nq]`.
    coordinates: Vec<f64>,
    linear: Vec<f64>,
    angular: Vec<f64>,
    /// Jacobian of the point evaluated last, m: `[3 x joints]`.
    pub(crate) rows: Vec<f64>,
}

impl IndependentKinematics {
    pub(crate) fn new(robot: &Robot) -> Self {
        let reduction = Reduction::new(robot);
        let (n, nv) = (reduction.independent().len(), robot.nv());
        Self {
            reduction,
            poses: Poses::new(robot),
            coordinates: vec![0.0; nv],
            linear: vec![0.0; 3 * nv],
            angular: vec![0.0; 3 * nv],
            rows: vec![0.0; 3 * n],
        }
    }

    /// Sets the pose by the independent joints, rad or m.
    ///
    /// # Errors
    /// As [`Reduction::expand`].
    pub(crate) fn evaluate(&mut self, robot: &Robot, x: &[f64]) -> Result<(), Error> {
        self.reduction.expand(robot, x, &mut self.coordinates)?;
        robot.forward_kinematics(&self.coordinates, &mut self.poses)
    }

    /// The same with links that bend under their weight.
    ///
    /// # Errors
    /// As [`Reduction::expand`].
    pub(crate) fn evaluate_bent(&mut self, robot: &Robot, x: &[f64]) -> Result<(), Error> {
        self.reduction.expand(robot, x, &mut self.coordinates)?;
        robot.bent_kinematics(&self.coordinates, &mut self.poses)
    }

    /// Position of a site in the world, m, with its Jacobian in `rows`.
    ///
    /// # Errors
    /// As [`point`](Self::point).
    pub(crate) fn site(&mut self, robot: &Robot, site: usize) -> Result<[f64; 3], Error> {
        let point = robot.site_pose(&self.poses, site).origin;
        self.point(robot, robot.parts().sites[site].body, point)?;
        Ok(point)
    }

    /// Writes the Jacobian of a point of a body, in the world, m, to `rows`.
    ///
    /// # Errors
    /// As [`Robot::jacobian`].
    pub(crate) fn point(&mut self, robot: &Robot, body: usize, point: [f64; 3]) -> Result<(), Error> {
        robot.jacobian(&self.poses, body, point, &mut self.linear, &mut self.angular)?;
        self.reduction.rows(&self.linear, &mut self.rows)
    }
}
