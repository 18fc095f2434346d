use super::motion::Trajectory;
use super::reference::Reference;
use super::violation::{Infeasibility, Violation};
use crate::body::{Joint, JointKind, Robot};
use crate::error::{Error, check_length, positive};
use crate::muscle::MuscleDynamics;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

/// Limits that a trajectory is checked against before a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Speed of every joint, rad/s or m/s, > 0.
    pub joint_speed: f64,
    /// Speed of every cable at its winch, m/s, > 0: `[muscles]`, or one number for all.
    pub cable_speed: Vec<f64>,
    /// Acceleration of every cable at its winch, m/s^2, > 0: `[muscles]`, or one number for all.
    pub cable_acceleration: Vec<f64>,
    /// Time between checked instants, s, > 0.
    pub interval: f64,
}

impl Default for Limits {
    /// 20 rad/s (the winches are the limit of most machines), 0.14 m/s and 5 m/s^2 (as of the paper's drive),
    /// every 10 ms.
    fn default() -> Self {
        Self { joint_speed: 20.0, cable_speed: vec![0.14], cable_acceleration: vec![5.0], interval: 0.01 }
    }
}

/// Torque of the independent joints that the tensions have to produce at one instant, with what their
/// followers add.
#[derive(Debug, Clone, Copy)]
pub struct TorqueDemand<'a> {
    /// Coordinates of the independent joints, `[n]`, rad or m.
    pub pose: &'a [f64],
    /// `R J`, `[muscles x n]`, row by row, m.
    pub moment_arms: &'a [f64],
    /// `J^T` (inverse dynamics minus passive forces), `[n]`, Nm or N.
    pub torque: &'a [f64],
}

/// The part of a joint torque that no tensions within their limits produce.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueDeficit {
    /// Index of the independent joint with the largest residual.
    pub velocity: usize,
    /// Residual there, Nm or N.
    pub torque: f64,
    /// The saturated muscle with the largest moment arm in its direction, and its tension, N.
    pub muscle: Option<(usize, f64)>,
    /// The muscle that the springs of its joints leave slack, its tension there, and the least that it may
    /// have, N.
    pub slack: Option<(usize, f64, f64)>,
}

/// Checks a whole trajectory, start and end included, and returns the first violated limit. A path that
/// leaves the workspace is reported before all others: no timing makes it feasible.
///
/// `torque_deficit` solves the tension distribution at one instant: solver and tension limits are the
/// caller's.
///
/// # Errors
/// [`Error::WrongLength`] where the trajectory is another robot's; [`Error::OutOfDomain`] for a limit that is
/// not positive; whatever `torque_deficit` returns.
pub fn first_infeasibility(
    robot: &Robot,
    trajectory: &Trajectory,
    limits: &Limits,
    mut torque_deficit: impl FnMut(TorqueDemand<'_>) -> Result<Option<TorqueDeficit>, Error>,
) -> Result<Option<Infeasibility>, Error> {
    positive("joint_speed", limits.joint_speed)?;
    positive("interval", limits.interval)?;
    let mut model = MuscleDynamics::new(robot)?;
    let joints = model.joints();
    check_length("joints of the trajectory", trajectory.joints(), joints)?;
    if let Some(unreached) = first_unreachable(trajectory) {
        return Ok(Some(unreached));
    }
    let mut winches = WinchCheck::new(&model, limits)?;
    let (mut now, mut torque) = (Reference::new(joints), vec![0.0; joints]);
    // At most a million instants: a trajectory of hours is checked more coarsely.
    let instants = libm::ceil(trajectory.duration() / limits.interval).min(1e6) as usize;
    let time_of = |k: usize| trajectory.duration() * k as f64 / instants.max(1) as f64;
    // First: on the way to a position that a joint does not have it is too fast as well.
    for time in (0..=instants).map(time_of) {
        trajectory.sample(time, &mut now)?;
        if let Some(violation) = range_violation(robot, &now.q) {
            return Ok(Some(Infeasibility { time, violation }));
        }
    }
    for time in (0..=instants).map(time_of) {
        let infeasible = |violation| Ok(Some(Infeasibility { time, violation }));
        trajectory.sample(time, &mut now)?;
        if let Some(violation) = winches.violation(&mut model, &now)? {
            return infeasible(violation);
        }
        model.inverse_dynamics(&now.v, &now.a, &mut torque)?;
        if let Some(violation) = joint_violation(&model, limits) {
            return infeasible(violation);
        }
        let moment_arms = model.moment_arms();
        if let Some(deficit) = torque_deficit(TorqueDemand { pose: &now.q, moment_arms, torque: &torque })? {
            if let Some((muscle, tension, least)) = deficit.slack {
                let muscle = muscle_name(robot, muscle);
                return infeasible(Violation::Slack { muscle, tension, least });
            }
            return infeasible(Violation::Torque {
                joint: independent_name(robot, deficit.velocity),
                needed: torque.get(deficit.velocity).copied().unwrap_or(f64::NAN),
                missing: deficit.torque,
                unit: independent_kind(robot, deficit.velocity).torque_unit(),
                muscle: deficit.muscle.map(|(muscle, tension)| (muscle_name(robot, muscle), tension)),
            });
        }
    }
    Ok(None)
}

/// Speeds and accelerations of the cables against the limits of their winches.
struct WinchCheck<'a> {
    limits: &'a Limits,
    ahead: Reference,
    speeds: Vec<f64>,
    speeds_ahead: Vec<f64>,
}

/// Step of the finite difference of cable speeds, s.
const DIFFERENCE_STEP: f64 = 1e-5;

impl<'a> WinchCheck<'a> {
    fn new(model: &MuscleDynamics, limits: &'a Limits) -> Result<Self, Error> {
        let muscles = model.muscles();
        for (name, list) in
            [("cable_speed", &limits.cable_speed), ("cable_acceleration", &limits.cable_acceleration)]
        {
            list.iter().try_for_each(|limit| positive(name, *limit).map(drop))?;
            if list.len() != 1 {
                check_length(name, list.len(), muscles)?;
            }
        }
        let ahead = Reference::new(model.joints());
        Ok(Self { limits, ahead, speeds: vec![0.0; muscles], speeds_ahead: vec![0.0; muscles] })
    }

    /// The first violated limit; afterwards the model is in the pose of the reference.
    fn violation(&mut self, model: &mut MuscleDynamics, now: &Reference) -> Result<Option<Violation>, Error> {
        for (k, q) in self.ahead.q.iter_mut().enumerate() {
            *q = now.q[k] + DIFFERENCE_STEP * now.v[k];
            self.ahead.v[k] = now.v[k] + DIFFERENCE_STEP * now.a[k];
        }
        model.evaluate(&self.ahead.q)?;
        model.anchor_motion(&self.ahead.v, &mut self.speeds_ahead);
        model.evaluate(&now.q)?;
        model.anchor_motion(&now.v, &mut self.speeds);
        let limit = |limits: &[f64], m: usize| limits.get(m).or(limits.first()).copied().unwrap_or(f64::NAN);
        for (m, (speed, later)) in self.speeds.iter().zip(&self.speeds_ahead).enumerate() {
            let (speed_limit, most) =
                (limit(&self.limits.cable_speed, m), limit(&self.limits.cable_acceleration, m));
            if speed.abs() > speed_limit {
                let muscle = muscle_name(model.robot(), m);
                return Ok(Some(Violation::CableSpeed { muscle, speed: speed.abs(), most: speed_limit }));
            }
            let acceleration = (later - speed).abs() / DIFFERENCE_STEP;
            if acceleration > most {
                let muscle = muscle_name(model.robot(), m);
                return Ok(Some(Violation::CableAcceleration { muscle, acceleration, most }));
            }
        }
        Ok(None)
    }
}

fn muscle_name(robot: &Robot, muscle: usize) -> String {
    robot.parts().tendons.get(muscle).map_or_else(|| muscle.to_string(), |tendon| tendon.name.clone())
}

/// Tolerance of a joint range, rad or m.
const RANGE_TOLERANCE: f64 = 1e-9;

/// Of the position of a joint, where it is outside of its range.
fn out_of_range(joint: &Joint, position: f64) -> Option<Violation> {
    let range = joint.range?;
    let inside = (range[0] - RANGE_TOLERANCE..=range[1] + RANGE_TOLERANCE).contains(&position);
    let (name, unit) = (joint.name.clone(), joint.kind.unit());
    (!inside).then_some(Violation::JointRange { joint: name, position, range, unit })
}

/// Of the positions of the independent joints.
fn range_violation(robot: &Robot, q: &[f64]) -> Option<Violation> {
    let mut joints = robot.independent_joints().into_iter().zip(q);
    joints.find_map(|(joint, position)| out_of_range(&robot.parts().joints[joint], *position))
}

/// Of coordinates and velocities of all joints, the coupled ones included.
fn joint_violation(model: &MuscleDynamics, limits: &Limits) -> Option<Violation> {
    let (robot, q, v) = (model.robot(), model.coordinates(), model.velocities());
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let coordinates = robot.coordinates_of(index);
        let violation = (coordinates.len() == 1).then(|| out_of_range(joint, q[coordinates.start])).flatten();
        if violation.is_some() {
            return violation;
        }
    }
    let fast = v.iter().position(|v| v.abs() > limits.joint_speed)?;
    let unit = robot
        .joint_of_velocity(fast)
        .map_or(JointKind::Hinge, |joint| robot.parts().joints[joint].kind)
        .unit();
    let joint = joint_name(robot, fast);
    Some(Violation::JointSpeed { joint, speed: v[fast].abs(), most: limits.joint_speed, unit })
}

/// Name of an independent joint.
fn independent_name(robot: &Robot, index: usize) -> String {
    let joint = robot.independent_joints().get(index).map(|&joint| robot.parts().joints[joint].name.clone());
    joint.unwrap_or_else(|| index.to_string())
}

fn independent_kind(robot: &Robot, index: usize) -> JointKind {
    let joint = robot.independent_joints().get(index).map(|&joint| robot.parts().joints[joint].kind);
    joint.unwrap_or(JointKind::Hinge)
}

fn joint_name(robot: &Robot, velocity: usize) -> String {
    let joint = robot.joint_of_velocity(velocity);
    joint.map_or_else(|| velocity.to_string(), |joint| robot.parts().joints[joint].name.clone())
}

/// The time at which a path leaves the workspace of its end point, by the time law, with the reason.
#[must_use]
pub fn first_unreachable(trajectory: &Trajectory) -> Option<Infeasibility> {
    let (joints, law) = match trajectory {
        Trajectory::AlongPath { joints, law } => (joints, law),
        Trajectory::PointToPoint(_) => return None,
        Trajectory::Sequence(motions) => {
            return motions.motions().find_map(|(start, motion)| {
                let Infeasibility { time, violation } = first_unreachable(motion)?;
                Some(Infeasibility { time: start + time, violation })
            });
        }
    };
    let unreached = joints.first_unreached()?;
    // The phase rises monotonically: bisection finds its time.
    let (mut time, mut upper) = (0.0, law.duration());
    for _ in 0..60 {
        let middle = 0.5 * (time + upper);
        if law.at(middle).phase < unreached.phase { time = middle } else { upper = middle }
    }
    Some(Infeasibility { time, violation: Violation::Unreachable(unreached.clone()) })
}
