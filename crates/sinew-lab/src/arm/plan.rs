//! Motion planning: from a motion of the end point to a joint trajectory, and its feasibility check.

use crate::Error;
use crate::experiment::oracle_models;
use sinew::body::{Poses, Robot};
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::trajectory::{
    self, EndPointPath, Infeasibility, JointPath, Limits, MinimumJerk, Redundancy, Reference, Sequence,
    TimeLaw, TorqueDeficit, TorqueDemand, Trajectory, Waypoint, split_at_rests,
};
use sinew::twin::arm::ArmSpecimen;

/// Turns of a closed path: the two periods of `yuan2023`.
const TURNS: f64 = 2.0;
/// Knots of the joint path over a turn or over a path through waypoints.
const KNOTS: usize = 720;
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
/// `duration` is in s; waypoints have their own times. A part of the motion that the end point cannot reach
/// is cut off: [`first_infeasibility`] reports it.
///
/// # Errors
/// [`Error::Physics`] where the robot has joints other than hinges and slides, and for numbers outside their
/// domain.
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
            // The next segment would start in another pose; the feasibility check reports where this one
            // ends.
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

/// The first time at which a limit is violated: of the joints, of speed or acceleration of a winch, or of the
/// tensions that the controller may ask for, where they cannot produce the torque.
///
/// # Errors
/// [`Error::Physics`] where trajectory and robot do not belong together, and for a robot with a muscle
/// without a sheath: its tension limits are unknown.
pub fn first_infeasibility(robot: &Robot, trajectory: &Trajectory) -> Result<Option<Infeasibility>, Error> {
    let gains = ArmGains::lm_arm();
    let mut torques = TorqueCheck::new(robot, tension_limits(robot, trajectory, &gains)?);
    let limits = Limits {
        cable_speed: gains.max_winch_speed,
        interval: check_interval(trajectory),
        ..Limits::default()
    };
    let check = |demand: TorqueDemand<'_>| torques.deficit(demand);
    Ok(trajectory::first_infeasibility(robot, trajectory, &limits, check)?)
}

/// Lower and upper tension limit of every muscle, N, by the controller's gains and cables as designed.
fn tension_limits(robot: &Robot, trajectory: &Trajectory, gains: &ArmGains) -> Result<Vec<[f64; 2]>, Error> {
    let design = ArmSpecimen::nominal(robot, &initial_pose(trajectory)?)?;
    oracle_models(&design).iter().map(|cable| Ok(gains.tension_limits(&cable.law()?))).collect()
}

/// Tension distribution within the limits of the muscles.
struct TorqueCheck {
    distribution: Distribution,
    joints: usize,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    zeros: Vec<f64>,
    ones: Vec<f64>,
}

impl TorqueCheck {
    fn new(robot: &Robot, limits: Vec<[f64; 2]>) -> Self {
        let (joints, muscles) = (robot.nv(), limits.len());
        let (minimum, maximum) = limits.into_iter().map(|[lower, upper]| (lower, upper)).unzip();
        Self {
            distribution: Distribution::new(muscles, joints),
            joints,
            minimum,
            maximum,
            zeros: vec![0.0; muscles],
            ones: vec![1.0; muscles],
        }
    }

    /// The part of a torque that no admissible tensions produce.
    ///
    /// # Errors
    /// As [`Distribution::solve`]: an invalid problem is not a feasible one.
    fn deficit(&mut self, demand: TorqueDemand<'_>) -> Result<Option<TorqueDeficit>, sinew::Error> {
        let Self { distribution, joints, minimum, maximum, zeros, ones } = self;
        let solution = distribution.solve(&Problem {
            moment_arms: demand.moment_arms,
            torque: demand.torque,
            minimum,
            maximum,
            reference: zeros,
            weight: ones,
        })?;
        if solution.status == Status::Optimal {
            return Ok(None);
        }
        let residual = solution.residual.iter().copied().enumerate();
        let (velocity, torque) =
            residual.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, f64::NAN));
        // The saturated muscle with the largest moment arm in the direction of the torque.
        let leverage =
            |muscle: usize| demand.moment_arms[muscle * *joints + velocity] * demand.torque[velocity];
        let muscle = (0..maximum.len())
            .filter(|&m| leverage(m) > 0.0 && solution.tension[m] >= maximum[m])
            .max_by(|&a, &b| leverage(a).total_cmp(&leverage(b)))
            .map(|m| (m, solution.tension[m]));
        Ok(Some(TorqueDeficit { velocity, torque, muscle }))
    }
}

/// Time between checked instants, s: at least fifty within each motion.
fn check_interval(trajectory: &Trajectory) -> f64 {
    let default = Limits::default().interval;
    match trajectory {
        Trajectory::Sequence(sequence) => {
            sequence.motions().map(|(_, motion)| check_interval(motion)).fold(default, f64::min)
        }
        _ => default.min(0.02 * trajectory.duration()).max(1e-3),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::trajectory::{Loop, Violation};

    fn lm_arm() -> Robot {
        let text = include_str!("../../../../models/lm_arm.toml");
        Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
    }

    fn sine(robot: &Robot) -> Trajectory {
        let motion = EndPointMotion::ClosedPath(EndPointPath::lm_arm(Loop::Sine));
        plan(robot, robot.site("endpoint").unwrap(), &motion, robot.key("start").unwrap(), 11.5).unwrap()
    }

    #[test]
    fn a_distribution_problem_that_is_invalid_is_an_error_and_not_feasible() {
        let robot = lm_arm();
        let mut check = TorqueCheck::new(&robot, vec![[25.0, 150.0]; 15]);
        let mut torque = vec![0.0; 7];
        let arms = vec![0.01; 15 * 7];
        torque[2] = f64::NAN;
        assert!(check.deficit(TorqueDemand { moment_arms: &arms, torque: &torque }).is_err());
        assert!(check.deficit(TorqueDemand { moment_arms: &arms[1..], torque: &[0.0; 7] }).is_err());
    }

    #[test]
    fn tension_limits_never_cross_and_a_payload_beyond_them_is_reported() {
        let robot = lm_arm();
        let trajectory = sine(&robot);
        let mut weak = ArmGains::lm_arm();
        weak.max_drive_tension = 1.0;
        for [lower, upper] in tension_limits(&robot, &trajectory, &weak).unwrap() {
            assert!(lower <= upper);
        }
        assert_eq!(first_infeasibility(&robot, &trajectory).unwrap(), None);
        let site = &robot.parts().sites[robot.site("endpoint").unwrap()];
        let loaded = robot.with_payload(site.body, site.position, 5.0).unwrap();
        let found = first_infeasibility(&loaded, &trajectory).unwrap().unwrap();
        assert!(matches!(found.violation, Violation::Torque { .. }), "{found}");
    }
}
