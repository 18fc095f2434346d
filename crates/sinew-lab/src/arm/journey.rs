//! From a path of the end point to joints in time that a robot can follow, or the first place where it cannot.

use super::tracking::first_pose;
use crate::Error;
use crate::experiment::arm::oracle_models;
use sinew::body::{Poses, Robot};
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::muscle::Muscles;
use sinew::trajectory::{
    Demand, EndPointPath, JointPath, Limits, MinimumJerk, Obstacle, Redundancy, Sequence, Shortfall, TimeLaw,
    Trajectory, Waypoint, first_obstacle, legs,
};
use sinew::twin::arm::ArmSpecimen;

/// Turns of a closed path, as the paper's two periods.
const TURNS: f64 = 2.0;
/// Knots of the joints over a turn.
const KNOTS: usize = 720;
/// Most where nothing is known of its cable, N.
const MOST_N: f64 = 400.0;

/// Where an end point is to go.
#[derive(Debug, Clone, PartialEq)]
pub enum Route {
    /// Twice round a closed path.
    Round(EndPointPath),
    /// Through places at their own times; a place given twice in a row is waited at.
    Through(Vec<Waypoint>),
    /// From the pose it is in to a place, m: every joint with minimum jerk.
    To([f64; 3]),
}

/// Joints in time for a route of a site from rest to rest, in `duration` seconds where the route has no times of its own.
///
/// # Errors
/// [`Error::Physics`] where the robot has joints other than hinges and slides or the numbers are none.
pub fn journey(
    robot: &Robot,
    site: usize,
    route: &Route,
    pose: &[f64],
    duration: f64,
) -> Result<Trajectory, Error> {
    let rule = if robot.parts().name == "lm_arm" { Redundancy::lm_arm() } else { Redundancy::near(pose) };
    match route {
        Route::Round(path) => along(robot, site, path, &rule, duration),
        Route::Through(points) => {
            // What swings once per turn does not where nothing turns: places alone say where the joints are.
            let swing = vec![0.0; rule.swing.len()];
            through(robot, site, points, &Redundancy { swing, ..rule })
        }
        Route::To(place) => to(robot, site, *place, pose, duration),
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

/// Straight in the joints: what the end point's straight route is for is the pose at its end.
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

/// The first place where the robot cannot follow: joints, speeds and accelerations of winches, and torques that no
/// tensions within the controller's limits give.
///
/// # Errors
/// [`Error::Physics`] where trajectory and robot do not belong together.
pub fn obstacle(robot: &Robot, trajectory: &Trajectory) -> Result<Option<Obstacle>, Error> {
    let gains = ArmGains::lm_arm();
    let (joints, muscles) = (robot.nv(), Muscles::new(robot).count());
    let mut distribution = Distribution::new(muscles, joints);
    let [least, most] = tensions(robot, trajectory, muscles, &gains)?;
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
        let largest = solution.residual.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let (velocity, torque) = largest.map(|(velocity, torque)| (velocity, *torque))?;
        let gives = |muscle: usize| {
            (demand.moment_arms[muscle * joints + velocity] * demand.torque[velocity]).max(0.0)
        };
        let muscle = (0..muscles)
            .filter(|&m| gives(m) > 0.0 && solution.tension[m] >= most[m])
            .max_by(|&a, &b| gives(a).total_cmp(&gives(b)))
            .map(|m| (m, solution.tension[m]));
        Some(Shortfall { velocity, torque, muscle })
    };
    let limits = Limits { cable_speed: gains.max_winch_speed, every: every(trajectory), ..Limits::default() };
    Ok(first_obstacle(robot, trajectory, &limits, reach)?)
}

/// Time between the places looked at, s: a short motion is not passed over.
fn every(trajectory: &Trajectory) -> f64 {
    let usual = Limits::default().every;
    match trajectory {
        Trajectory::Sequence(sequence) => {
            sequence.motions().map(|(_, motion)| every(motion)).fold(usual, f64::min)
        }
        _ => usual.min(0.02 * trajectory.duration()).max(1e-3),
    }
}

/// Least and most tension of every muscle, N: what the controller asks of cables that are as designed.
fn tensions(
    robot: &Robot,
    trajectory: &Trajectory,
    muscles: usize,
    gains: &ArmGains,
) -> Result<[Vec<f64>; 2], Error> {
    let Ok(design) = ArmSpecimen::nominal(robot, &first_pose(trajectory)?) else {
        return Ok([vec![gains.min_tension; muscles], vec![MOST_N; muscles]]);
    };
    let [mut least, mut most] = [Vec::new(), Vec::new()];
    for cable in oracle_models(&design) {
        let law = cable.law()?;
        least.push(gains.min_tension.max(law.pretension() + gains.pretension_margin));
        most.push(gains.max_drive_tension * (-law.friction_angle()).exp() + law.pretension());
    }
    Ok([least, most])
}
