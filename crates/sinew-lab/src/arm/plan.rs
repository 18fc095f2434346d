//! Motion planning: from a motion of the end point to a joint trajectory, and its feasibility check.

use crate::Error;
use crate::experiment::arm::oracle_models;
use sinew::body::{Poses, Robot};
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::muscle::Muscles;
use sinew::trajectory::{
    self, EndPointPath, Infeasibility, JointPath, Limits, MinimumJerk, Redundancy, Reference, Sequence,
    TimeLaw, TorqueDeficit, TorqueDemand, Trajectory, Waypoint, split_at_rests,
};
use sinew::twin::arm::ArmSpecimen;

/// Turns of a closed path: the two periods of `yuan2023`.
const TURNS: f64 = 2.0;
/// Knots of the joint path over a turn or over a path through waypoints.
const KNOTS: usize = 720;
/// Upper tension limit of a muscle without a sheath, N.
const MAXIMUM_TENSION_N: f64 = 400.0;

/// A desired motion of the end point.
#[derive(Debug, Clone, PartialEq)]
pub enum EndPointMotion {
    /// Two turns of a closed path.
    ClosedPath(EndPointPath),
    /// Through waypoints at given times, with a stop where one is given twice in a row.
    Waypoints(Vec<Waypoint>),
    /// From the initial pose to a position, m; every joint moves with minimum jerk.
    PointToPoint([f64; 3]),
}

/// Plans a joint trajectory, from rest to rest, on which `site` performs a motion that starts near `pose`.
///
/// `duration` is in s; waypoints have their own times. A part of the motion that the end point cannot reach is cut off:
/// [`first_infeasibility`] reports it.
///
/// # Errors
/// [`Error::Physics`] where the robot has joints other than hinges and slides, and for numbers outside their domain.
pub fn plan(
    robot: &Robot,
    site: usize,
    motion: &EndPointMotion,
    pose: &[f64],
    duration: f64,
) -> Result<Trajectory, Error> {
    let rule = if robot.parts().name == "lm_arm" { Redundancy::lm_arm() } else { Redundancy::near(pose) };
    match motion {
        EndPointMotion::ClosedPath(path) => along_path(robot, site, path, &rule, duration),
        EndPointMotion::Waypoints(points) => {
            // The periodic part of the preferred pose belongs to the phase of a closed path.
            let swing = vec![0.0; rule.swing.len()];
            through_waypoints(robot, site, points, &Redundancy { swing, ..rule })
        }
        EndPointMotion::PointToPoint(position) => point_to_point(robot, site, *position, pose, duration),
    }
}

fn through_waypoints(
    robot: &Robot,
    site: usize,
    points: &[Waypoint],
    rule: &Redundancy,
) -> Result<Trajectory, Error> {
    let mut motions = Vec::new();
    let mut end =
        points.last().map_or(0.0, |last| last.time) - points.first().map_or(0.0, |first| first.time);
    for segment in split_at_rests(points)? {
        let motion = along_path(robot, site, &segment.path, rule, end)?;
        let unreached =
            matches!(&motion, Trajectory::AlongPath { joints, .. } if joints.first_unreached().is_some());
        motions.push((segment.start, motion));
        if unreached {
            // The next segment would start in another pose; the feasibility check reports where this one ends.
            end = motions.last().map_or(0.0, |(start, motion)| start + motion.duration());
            break;
        }
    }
    Ok(Trajectory::Sequence(Sequence::new(motions, end)?))
}

/// Minimum jerk in joint space; the final pose is found along the straight line of the end point.
fn point_to_point(
    robot: &Robot,
    site: usize,
    position: [f64; 3],
    pose: &[f64],
    duration: f64,
) -> Result<Trajectory, Error> {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(pose, &mut poses)?;
    let start = robot.site_pose(&poses, site).origin;
    let ends = [(0.0, start), (duration, position)].map(|(time, position)| Waypoint { time, position });
    let line = EndPointPath::through(&ends)?;
    let straight = along_path(robot, site, &line, &Redundancy::near(pose), duration)?;
    match &straight {
        Trajectory::AlongPath { joints, law } if joints.first_unreached().is_none() => {
            let final_pose = joints.pose(law.at(duration).phase);
            Ok(Trajectory::PointToPoint(MinimumJerk::new(pose, &final_pose, duration)?))
        }
        _ => Ok(straight),
    }
}

fn along_path(
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
pub fn first_infeasibility(robot: &Robot, trajectory: &Trajectory) -> Result<Option<Infeasibility>, Error> {
    let gains = ArmGains::lm_arm();
    let (joints, muscles) = (robot.nv(), Muscles::new(robot).count());
    let mut distribution = Distribution::new(muscles, joints);
    let [least, most] = tensions(robot, trajectory, muscles, &gains)?;
    let (reference, weight) = (vec![0.0; muscles], vec![1.0; muscles]);
    let reach = |demand: TorqueDemand<'_>| {
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
        Some(TorqueDeficit { velocity, torque, muscle })
    };
    let limits = Limits {
        cable_speed: gains.max_winch_speed,
        interval: check_interval(trajectory),
        ..Limits::default()
    };
    Ok(trajectory::first_infeasibility(robot, trajectory, &limits, reach)?)
}

/// Time between the places looked at, s: a short motion is not passed over.
fn check_interval(trajectory: &Trajectory) -> f64 {
    let usual = Limits::default().interval;
    match trajectory {
        Trajectory::Sequence(sequence) => {
            sequence.motions().map(|(_, motion)| check_interval(motion)).fold(usual, f64::min)
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
    let Ok(design) = ArmSpecimen::nominal(robot, &initial_pose(trajectory)?) else {
        return Ok([vec![gains.min_tension; muscles], vec![MAXIMUM_TENSION_N; muscles]]);
    };
    let [mut least, mut most] = [Vec::new(), Vec::new()];
    for cable in oracle_models(&design) {
        let law = cable.law()?;
        least.push(gains.min_tension.max(law.pretension() + gains.pretension_margin));
        most.push(gains.max_drive_tension * (-law.friction_angle()).exp() + law.pretension());
    }
    Ok([least, most])
}

/// The pose in which a trajectory begins.
///
/// # Errors
/// As [`Trajectory::sample`].
pub fn initial_pose(trajectory: &Trajectory) -> Result<Vec<f64>, Error> {
    let mut first = Reference::new(trajectory.joints());
    trajectory.sample(0.0, &mut first)?;
    Ok(first.q)
}
