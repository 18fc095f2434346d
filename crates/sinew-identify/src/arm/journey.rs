//! From a path of the end point to joints in time that a robot can follow, or the first place where it cannot.

use super::tracking::first_pose;
use crate::Error;
use sinew::body::{Poses, Robot};
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::experiment::arm::perfect_models;
use sinew::predictor::CableModel;
use sinew::trajectory::{
    Demand, EndPointPath, JointPath, Limits, MinimumJerk, Obstacle, Redundancy, Sequence, Shortfall, TimeLaw,
    Trajectory, Waypoint, first_obstacle, legs,
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

/// Where an end point is to go.
#[derive(Debug, Clone, PartialEq)]
pub enum Way {
    /// Twice round a closed path.
    Round(EndPointPath),
    /// Through places at their own times; a place given twice in a row is waited at.
    Through(Vec<Waypoint>),
    /// From the pose it is in to a place, m: every joint with minimum jerk.
    To([f64; 3]),
}

/// Joints in time for a way of a site from rest to rest, in `duration` seconds where the way has no times of its own.
///
/// # Errors
/// [`Error::Physics`] where the robot has joints other than hinges and slides or the numbers are none.
pub fn journey(
    robot: &Robot,
    site: usize,
    way: &Way,
    pose: &[f64],
    duration: f64,
) -> Result<Trajectory, Error> {
    let rule = if robot.parts().name == "lm_arm" { Redundancy::lm_arm() } else { Redundancy::near(pose) };
    match way {
        Way::Round(path) => along(robot, site, path, &rule, duration),
        Way::Through(points) => {
            // What swings once per turn does not where nothing turns: places alone say where the joints are.
            let swing = vec![0.0; rule.swing.len()];
            through(robot, site, points, &Redundancy { swing, ..rule })
        }
        Way::To(place) => to(robot, site, *place, pose, duration),
    }
}

fn through(robot: &Robot, site: usize, points: &[Waypoint], rule: &Redundancy) -> Result<Trajectory, Error> {
    let mut motions = Vec::new();
    let mut end =
        points.last().map_or(0.0, |last| last.time) - points.first().map_or(0.0, |first| first.time);
    for leg in legs(points)? {
        let motion = along(robot, site, &leg.path, rule, end)?;
        let missed = matches!(&motion, Trajectory::AlongPath { joints, .. } if joints.missed().is_some());
        motions.push((leg.start, motion));
        if missed {
            // What comes after begins elsewhere; the check says where this one ends.
            end = motions.last().map_or(0.0, |(start, motion)| start + motion.duration());
            break;
        }
    }
    Ok(Trajectory::Sequence(Sequence::new(motions, end)?))
}

/// Straight in the joints: what the end point's straight way is for is the pose at its end.
fn to(robot: &Robot, site: usize, place: [f64; 3], pose: &[f64], duration: f64) -> Result<Trajectory, Error> {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(pose, &mut poses)?;
    let here = robot.site_pose(&poses, site).origin;
    let ends = [(0.0, here), (duration, place)].map(|(time, position)| Waypoint { time, position });
    let straight = along(robot, site, &EndPointPath::through(&ends)?, &Redundancy::near(pose), duration)?;
    match &straight {
        Trajectory::AlongPath { joints, law } if joints.missed().is_none() => {
            let there = joints.pose(law.at(duration).phase);
            Ok(Trajectory::PointToPoint(MinimumJerk::new(pose, &there, duration)?))
        }
        _ => Ok(straight),
    }
}

fn along(
    robot: &Robot,
    site: usize,
    path: &EndPointPath,
    rule: &Redundancy,
    duration: f64,
) -> Result<Trajectory, Error> {
    let joints = JointPath::resolve(robot, site, path, rule, KNOTS)?;
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
