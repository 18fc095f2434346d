use super::motion::Trajectory;
use super::reference::Reference;
use crate::body::{Robot, Scratch};
use crate::error::{Error, check_length, positive};
use crate::muscle::{Geometry, Muscles};
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// Limits that a trajectory is checked against before a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Speed of every joint, rad/s or m/s, > 0.
    pub joint_speed: f64,
    /// Speed of every cable at its winch, m/s, > 0.
    pub cable_speed: f64,
    /// Acceleration of every cable at its winch, m/s^2, > 0.
    pub cable_acceleration: f64,
    /// Time between checked instants, s, > 0.
    pub interval: f64,
}

impl Default for Limits {
    /// 5 rad/s (above the operating range of the arm), 0.14 m/s (no-load speed of the drive), 5 m/s^2 (limit
    /// of its reference), every 10 ms.
    fn default() -> Self {
        Self { joint_speed: 5.0, cable_speed: 0.14, cable_acceleration: 5.0, interval: 0.01 }
    }
}

/// Joint torque that the tensions have to produce at one instant.
#[derive(Debug, Clone, Copy)]
pub struct TorqueDemand<'a> {
    /// `R`, `[muscles x nv]`, row by row, m.
    pub moment_arms: &'a [f64],
    /// Inverse dynamics minus passive forces, `[nv]`, Nm or N.
    pub torque: &'a [f64],
}

/// The part of a joint torque that no tensions within their limits produce.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueDeficit {
    /// Index of the velocity with the largest residual.
    pub velocity: usize,
    /// Residual there, Nm or N.
    pub torque: f64,
    /// The saturated muscle with the largest moment arm in its direction, and its tension, N.
    pub muscle: Option<(usize, f64)>,
}

/// A violated limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Violation {
    /// The path leaves the workspace of the end point.
    Unreachable {
        /// Phase of the path: rad on a closed path, s between waypoints.
        phase: f64,
        /// Remaining position error, m; 0 where the path closes and the joints do not.
        distance: f64,
    },
    /// A joint outside its range.
    JointRange {
        /// Its name.
        joint: String,
        /// rad or m.
        position: f64,
        /// rad or m.
        range: [f64; 2],
    },
    /// A joint above its speed limit.
    JointSpeed {
        /// Its name.
        joint: String,
        /// rad/s or m/s.
        speed: f64,
        /// rad/s or m/s.
        most: f64,
    },
    /// A cable above the speed limit of its winch.
    CableSpeed {
        /// Its name.
        muscle: String,
        /// m/s.
        speed: f64,
        /// m/s.
        most: f64,
    },
    /// A cable above the acceleration limit of its winch.
    CableAcceleration {
        /// Its name.
        muscle: String,
        /// m/s^2.
        acceleration: f64,
        /// m/s^2.
        most: f64,
    },
    /// A joint torque that the tension limits do not admit.
    Torque {
        /// Name of the joint.
        joint: String,
        /// Required, Nm or N.
        needed: f64,
        /// Residual, Nm or N.
        missing: f64,
        /// The saturated muscle with the largest moment arm in its direction, and its tension, N.
        muscle: Option<(String, f64)>,
    },
}

/// The first time at which a trajectory violates a limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Infeasibility {
    /// From the start, s.
    pub time: f64,
    /// The limit that is violated.
    pub violation: Violation,
}

impl fmt::Display for Infeasibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {:.3} s: ", self.time)?;
        match &self.violation {
            Violation::Unreachable { phase, distance } if *distance > 0.0 => {
                write!(
                    f,
                    "the path leaves the reach of the end point (phase {phase:.3}, {distance:.1e} m away)"
                )
            }
            Violation::Unreachable { phase, .. } => {
                write!(f, "the path closes, but the joints do not (phase {phase:.3})")
            }
            Violation::JointRange { joint, position, range: [low, high] } => {
                write!(
                    f,
                    "joint `{joint}` must be within {low:.5} and {high:.5}, but the reference is {position:.5}"
                )
            }
            Violation::JointSpeed { joint, speed, most } => {
                write!(f, "joint `{joint}` may move at most {most:.3} per s, but the reference is {speed:.3}")
            }
            Violation::CableSpeed { muscle, speed, most } => {
                write!(
                    f,
                    "the winch of `{muscle}` winds at most {most:.3} m/s, but the reference needs {speed:.3}"
                )
            }
            Violation::CableAcceleration { muscle, acceleration, most } => {
                write!(
                    f,
                    "the winch of `{muscle}` accelerates by at most {most:.3} m/s^2, but the reference needs {acceleration:.3}"
                )
            }
            Violation::Torque { joint, needed, missing, muscle } => {
                write!(
                    f,
                    "`{joint}` needs {:.3} N m, of which tensions within their limits leave {} N m unmet",
                    needed.abs(),
                    Significant(missing.abs())
                )?;
                match muscle {
                    Some((muscle, tension)) => write!(
                        f,
                        ": `{muscle}` is at {tension:.0} N, what its drive holds continuously less the friction \
                         of its cable"
                    ),
                    None => Ok(()),
                }
            }
        }
    }
}

/// A positive number with at least two significant digits, and at least three decimals.
struct Significant(f64);

impl fmt::Display for Significant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let leading = -libm::floor(libm::log10(self.0.max(1e-12)));
        write!(f, "{:.*}", (leading + 1.0).max(3.0) as usize, self.0)
    }
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
    positive("cable_speed", limits.cable_speed)?;
    positive("cable_acceleration", limits.cable_acceleration)?;
    positive("interval", limits.interval)?;
    // The checks below index poses joint by joint.
    check_length("joints of the trajectory", trajectory.joints(), robot.nq())?;
    check_length("joints of the trajectory", trajectory.joints(), robot.nv())?;
    if let Some((time, violation)) = first_unreachable(trajectory) {
        return Ok(Some(Infeasibility { time, violation }));
    }
    let muscles = Muscles::new(robot);
    let mut winches = WinchCheck::new(robot, &muscles);
    let mut scratch = Scratch::new(robot);
    let mut now = Reference::new(trajectory.joints());
    let (mut torque, mut passive) = (vec![0.0; robot.nv()], vec![0.0; robot.nv()]);
    let mut arms = vec![0.0; muscles.count() * robot.nv()];
    // At most a million instants: a trajectory of hours is checked more coarsely.
    let instants = libm::ceil(trajectory.duration() / limits.interval).min(1e6) as usize;
    for k in 0..=instants {
        let time = trajectory.duration() * k as f64 / instants.max(1) as f64;
        let infeasible = |violation| Ok(Some(Infeasibility { time, violation }));
        trajectory.sample(time, &mut now)?;
        if let Some(violation) = joint_violation(robot, &now, limits) {
            return infeasible(violation);
        }
        if let Some(violation) = winches.violation(robot, &now, limits)? {
            return infeasible(violation);
        }
        robot.inverse_dynamics(&now.q, &now.v, &now.a, &mut scratch, &mut torque)?;
        robot.passive_force(&now.q, &now.v, &mut passive)?;
        torque.iter_mut().zip(&passive).for_each(|(torque, passive)| *torque -= passive);
        muscles.dense(&winches.geometry, &mut arms)?;
        if let Some(deficit) = torque_deficit(TorqueDemand { moment_arms: &arms, torque: &torque })? {
            return infeasible(Violation::Torque {
                joint: joint_name(robot, deficit.velocity),
                needed: torque.get(deficit.velocity).copied().unwrap_or(f64::NAN),
                missing: deficit.torque,
                muscle: deficit.muscle.map(|(muscle, tension)| (muscle_name(robot, muscle), tension)),
            });
        }
    }
    Ok(None)
}

/// Speeds and accelerations of the cables against the limits of their winches.
struct WinchCheck<'a> {
    muscles: &'a Muscles,
    geometry: Geometry,
    ahead: Reference,
    speeds: Vec<f64>,
    speeds_ahead: Vec<f64>,
}

/// Step of the finite difference of cable speeds, s.
const DIFFERENCE_STEP: f64 = 1e-5;

impl<'a> WinchCheck<'a> {
    fn new(robot: &Robot, muscles: &'a Muscles) -> Self {
        Self {
            geometry: Geometry::new(robot, muscles),
            ahead: Reference::new(robot.nv()),
            speeds: vec![0.0; muscles.count()],
            speeds_ahead: vec![0.0; muscles.count()],
            muscles,
        }
    }

    /// The first violated limit; afterwards `geometry` is that of the reference pose.
    fn violation(
        &mut self,
        robot: &Robot,
        now: &Reference,
        limits: &Limits,
    ) -> Result<Option<Violation>, Error> {
        for (k, q) in self.ahead.q.iter_mut().enumerate() {
            *q = now.q[k] + DIFFERENCE_STEP * now.v[k];
            self.ahead.v[k] = now.v[k] + DIFFERENCE_STEP * now.a[k];
        }
        self.muscles.evaluate(&self.ahead.q, &mut self.geometry)?;
        self.muscles.velocities(&self.geometry, &self.ahead.v, &mut self.speeds_ahead)?;
        self.muscles.evaluate(&now.q, &mut self.geometry)?;
        self.muscles.velocities(&self.geometry, &now.v, &mut self.speeds)?;
        for (m, (speed, later)) in self.speeds.iter().zip(&self.speeds_ahead).enumerate() {
            if speed.abs() > limits.cable_speed {
                let muscle = muscle_name(robot, m);
                let (speed, most) = (speed.abs(), limits.cable_speed);
                return Ok(Some(Violation::CableSpeed { muscle, speed, most }));
            }
            let acceleration = (later - speed).abs() / DIFFERENCE_STEP;
            if acceleration > limits.cable_acceleration {
                let (muscle, most) = (muscle_name(robot, m), limits.cable_acceleration);
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

fn joint_violation(robot: &Robot, now: &Reference, limits: &Limits) -> Option<Violation> {
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let coordinates = robot.coordinates_of(index);
        if let (Some(range), 1) = (joint.range, coordinates.len()) {
            let position = now.q[coordinates.start];
            if position < range[0] - RANGE_TOLERANCE || position > range[1] + RANGE_TOLERANCE {
                return Some(Violation::JointRange { joint: joint.name.clone(), position, range });
            }
        }
    }
    let fast = now.v.iter().position(|v| v.abs() > limits.joint_speed)?;
    let joint = joint_name(robot, fast);
    Some(Violation::JointSpeed { joint, speed: now.v[fast].abs(), most: limits.joint_speed })
}

fn joint_name(robot: &Robot, velocity: usize) -> String {
    let joint = robot.joint_of_velocity(velocity);
    joint.map_or_else(|| velocity.to_string(), |joint| robot.parts().joints[joint].name.clone())
}

/// The time at which the path leaves the workspace, by the time law.
fn first_unreachable(trajectory: &Trajectory) -> Option<(f64, Violation)> {
    let (joints, law) = match trajectory {
        Trajectory::AlongPath { joints, law } => (joints, law),
        Trajectory::PointToPoint(_) => return None,
        Trajectory::Sequence(motions) => {
            return motions.motions().find_map(|(start, motion)| {
                let (time, violation) = first_unreachable(motion)?;
                Some((start + time, violation))
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
    Some((time, Violation::Unreachable { phase: unreached.phase, distance: unreached.distance }))
}
