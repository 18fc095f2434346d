//! From a path of the end point to joints in time that a robot can follow, or the first place where it cannot.

use super::tracking::first_pose;
use crate::Error;
use sinew::body::Robot;
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::experiment::arm::perfect_models;
use sinew::predictor::CableModel;
use sinew::trajectory::{
    Demand, EndPointPath, JointPath, Limits, Obstacle, Redundancy, Shortfall, TimeLaw, Trajectory,
    first_obstacle,
};
use sinew::twin::arm::ArmSpecimen;

/// Turns of a closed path, as the paper's two periods.
const TURNS: f64 = 2.0;
/// Knots of the joints over a turn.
const KNOTS: usize = 720;
/// Least tension of a muscle, N.
const LEAST_N: f64 = 20.0;
/// Most where nothing is known of its cable, N.
const MOST_N: f64 = 400.0;

/// Joints in time for a path of a site: closed paths twice round in `duration` seconds from rest to rest, waypoints at their own
/// times.
///
/// # Errors
/// [`Error::Physics`] where the robot has joints other than hinges and slides or the numbers are none.
pub fn journey(
    robot: &Robot,
    site: usize,
    path: &EndPointPath,
    pose: &[f64],
    duration: f64,
) -> Result<Trajectory, Error> {
    let redundancy =
        if robot.parts().name == "lm_arm" { Redundancy::lm_arm() } else { Redundancy::near(pose) };
    let joints = JointPath::resolve(robot, site, path, &redundancy, KNOTS)?;
    let law = match path {
        EndPointPath::Loop { .. } => TimeLaw::new(TURNS * path.length(), duration)?,
        EndPointPath::Waypoints { law, .. } => *law,
    };
    Ok(Trajectory::AlongPath { joints, law })
}

/// The first place where the robot cannot follow: joints, speeds, and torques that no tensions give.
///
/// # Errors
/// [`Error::Physics`] where trajectory and robot do not belong together.
pub fn obstacle(robot: &Robot, trajectory: &Trajectory) -> Result<Option<Obstacle>, Error> {
    let joints = robot.nv();
    let muscles = sinew::muscle::Muscles::new(robot).count();
    let mut distribution = Distribution::new(muscles, joints);
    let (least, most) = (vec![LEAST_N; muscles], most(robot, trajectory, muscles)?);
    let (reference, weight) = (vec![0.0; muscles], vec![1.0; muscles]);
    let reach = |demand: Demand<'_>| {
        let problem = Problem {
            moment_arms: demand.moment_arms,
            torque: demand.torque,
            minimum: &least,
            maximum: &most,
            reference: &reference,
            weight: &weight,
        };
        // What is no problem is no torque that can be given.
        let solution = distribution.solve(&problem).ok()?;
        if solution.status == Status::Optimal {
            return None;
        }
        let most = solution.residual.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        most.map(|(velocity, torque)| Shortfall { velocity, torque: *torque })
    };
    Ok(first_obstacle(robot, trajectory, &Limits::default(), reach)?)
}

/// What every drive gives at its anchor for ever, N, by the cables as designed.
fn most(robot: &Robot, trajectory: &Trajectory, muscles: usize) -> Result<Vec<f64>, Error> {
    let drive = ArmGains::lm_arm().drive_tension;
    let Ok(design) = ArmSpecimen::nominal(robot, &first_pose(trajectory)?) else {
        return Ok(vec![MOST_N; muscles]);
    };
    let most = |cable: &CableModel| {
        let law = cable.law()?;
        Ok(drive * (-law.friction_angle()).exp() + law.pretension())
    };
    perfect_models(&design).iter().map(most).collect()
}
