//! Motion planning: from a desired motion of a machine to a trajectory of its independent joints.

use crate::Error;
use sinew::machine::{Machine, Task};
use sinew::trajectory::{
    EndPointPath, Equilibrium, Infeasibility, JointPath, JointWaypoint, MinimumJerk, Redundancy, Sequence,
    TimeLaw, Trajectory, Waypoint, feasible_tour, split_at_rests, through_joint_waypoints,
};

/// Turns of a closed path: the two periods of `yuan2023`.
const TURNS: f64 = 2.0;
/// Knots of the joint path over a turn or over a path through waypoints.
const KNOTS: usize = 720;
/// Duration of two turns of a closed path where none is given, s.
pub const CLOSED_PATH_S: f64 = 40.0;
/// The same of a motion to a point or a pose, s.
const POINT_TO_POINT_S: f64 = 5.0;

/// A desired motion, from rest to rest.
#[derive(Debug, Clone, PartialEq)]
pub enum DesiredMotion {
    /// Two turns of a closed path of the end point.
    ClosedPath(EndPointPath),
    /// Of the end point through waypoints at given times, with a stop where one is given twice in a row.
    Waypoints(Vec<Waypoint>),
    /// From the start pose until the end point is at a position, m; every joint moves with minimum jerk.
    ToPoint([f64; 3]),
    /// Of the joints through poses at given times, with a stop where one is given twice in a row.
    JointWaypoints(Vec<JointWaypoint>),
    /// From the start pose to a pose of the independent joints, with minimum jerk.
    ToPose(Vec<f64>),
}

impl DesiredMotion {
    /// Whether it prescribes the end point, which a machine may not have.
    #[must_use]
    pub fn needs_end_point(&self) -> bool {
        matches!(self, Self::ClosedPath(_) | Self::Waypoints(_) | Self::ToPoint(_))
    }

    /// Whether its points have times, so that a duration is not used.
    #[must_use]
    pub fn has_times(&self) -> bool {
        matches!(self, Self::Waypoints(_) | Self::JointWaypoints(_))
    }
}

/// Plans a trajectory of the independent joints, from rest to rest.
///
/// `duration` is in s; by default 40 s for a closed path, 5 s to a point or a pose. Waypoints have their own
/// times. A part of the motion that the end point cannot reach is cut off:
/// [`first_infeasibility`](super::first_infeasibility) reports it. Where cables leave joints to springs,
/// poses stand for the lengths of the cables in them: see [`Equilibrium::along`].
///
/// # Errors
/// [`Error::Experiment`] for a motion of the end point where the machine's task has none; [`Error::Physics`]
/// where the robot has joints other than hinges and slides, and for numbers outside their domain.
pub fn plan(machine: &Machine, motion: &DesiredMotion, duration: Option<f64>) -> Result<Trajectory, Error> {
    let Some(mut equilibrium) = Equilibrium::new(&machine.robot)? else {
        return plan_joints(machine, motion, duration);
    };
    if motion.needs_end_point() {
        let expected = "one of the joints (tour, to-joints: or joints:): fewer motors than joints, and the \
            lengths of the cables are planned";
        return Err(Error::experiment("motion", expected, &"a path of the end point"));
    }
    Ok(equilibrium.along(&plan_joints(machine, motion, duration)?)?)
}

/// The same of the joints, each with a motor.
fn plan_joints(
    machine: &Machine,
    motion: &DesiredMotion,
    duration: Option<f64>,
) -> Result<Trajectory, Error> {
    let start = &machine.start;
    match motion {
        DesiredMotion::ClosedPath(path) => {
            let duration = duration.unwrap_or(CLOSED_PATH_S);
            EndPoint::new(machine)?.along_path(path, &machine.redundancy, duration)
        }
        DesiredMotion::Waypoints(points) => {
            // The periodic part of the preferred pose belongs to the phase of a closed path.
            let rule = &machine.redundancy;
            let rule = Redundancy { swing: vec![0.0; rule.swing.len()], ..rule.clone() };
            EndPoint::new(machine)?.through_waypoints(points, &rule)
        }
        DesiredMotion::ToPoint(position) => {
            let duration = duration.unwrap_or(POINT_TO_POINT_S);
            EndPoint::new(machine)?.to_point(*position, start, duration)
        }
        DesiredMotion::JointWaypoints(points) => Ok(through_joint_waypoints(points)?),
        DesiredMotion::ToPose(pose) => {
            let duration = duration.unwrap_or(POINT_TO_POINT_S);
            Ok(Trajectory::PointToPoint(MinimumJerk::new(start, pose, duration)?))
        }
    }
}

/// Plans a closed motion of all joints that every cable takes part in; see [`sinew::trajectory::Tour`].
///
/// Without a `duration`, s, it is made slower until `check` finds no violated limit.
///
/// # Errors
/// As [`feasible_tour`].
pub fn plan_tour(
    machine: &Machine,
    duration: Option<f64>,
    check: impl FnMut(&Trajectory) -> Result<Option<Infeasibility>, Error>,
) -> Result<Trajectory, Error> {
    feasible_tour(&machine.robot, &machine.start, duration, check)
}

/// The end point of a machine, and those of its coordinates that are tracked.
struct EndPoint<'a> {
    machine: &'a Machine,
    site: usize,
    axes: [bool; 3],
}

impl<'a> EndPoint<'a> {
    fn new(machine: &'a Machine) -> Result<Self, Error> {
        match machine.task {
            Task::EndPoint { site, axes } => Ok(Self { machine, site, axes }),
            Task::Joints => {
                Err(Error::experiment("motion", "one of the joints: the machine has no end point", &"a path"))
            }
        }
    }

    fn along_path(&self, path: &EndPointPath, rule: &Redundancy, duration: f64) -> Result<Trajectory, Error> {
        let joints = JointPath::resolve_axes(&self.machine.robot, self.site, self.axes, path, rule, KNOTS)?;
        let law = match path {
            EndPointPath::Loop { .. } => TimeLaw::new(TURNS * path.length(), duration)?,
            EndPointPath::Waypoints { law, .. } => *law,
        };
        Ok(Trajectory::AlongPath { joints, law })
    }

    fn through_waypoints(&self, points: &[Waypoint], rule: &Redundancy) -> Result<Trajectory, Error> {
        let mut motions = Vec::new();
        let mut end =
            points.last().map_or(0.0, |last| last.time) - points.first().map_or(0.0, |first| first.time);
        for segment in split_at_rests(points)? {
            let motion = self.along_path(&segment.path, rule, end)?;
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
    fn to_point(&self, position: [f64; 3], start: &[f64], duration: f64) -> Result<Trajectory, Error> {
        let robot = &self.machine.robot;
        let mut poses = sinew::body::Poses::new(robot);
        robot.forward_kinematics(&robot.pose_from_independent(start)?, &mut poses)?;
        let origin = robot.site_pose(&poses, self.site).origin;
        let ends = [(0.0, origin), (duration, position)].map(|(time, position)| Waypoint { time, position });
        let line = EndPointPath::through(&ends)?;
        let straight = self.along_path(&line, &Redundancy::near(start), duration)?;
        match &straight {
            Trajectory::AlongPath { joints, law } if joints.first_unreached().is_none() => {
                let final_pose = joints.pose(law.at(duration).phase);
                Ok(Trajectory::PointToPoint(MinimumJerk::new(start, &final_pose, duration)?))
            }
            _ => Ok(straight),
        }
    }
}
