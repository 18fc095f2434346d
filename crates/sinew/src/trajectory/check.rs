use super::motion::{Reference, Trajectory};
use crate::body::{Robot, Scratch};
use crate::error::{Error, check_length, positive};
use crate::muscle::{Geometry, Muscles};
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// What the robot can do, for the check before a start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Of every joint, rad/s or m/s, > 0.
    pub joint_speed: f64,
    /// Of every cable: what its winch can wind, m/s, > 0.
    pub cable_speed: f64,
    /// Of every cable: how fast its winch can change that, m/s^2, > 0.
    pub cable_acceleration: f64,
    /// Time between the places looked at, s, > 0.
    pub interval: f64,
}

impl Default for Limits {
    /// 5 rad/s (more than an arm is driven at), 0.14 m/s (the drive's no-load speed), 5 m/s^2 (its limit), every 10 ms.
    fn default() -> Self {
        Self { joint_speed: 5.0, cable_speed: 0.14, cable_acceleration: 5.0, interval: 0.01 }
    }
}

/// What tensions are asked for at one place of a trajectory.
#[derive(Debug, Clone, Copy)]
pub struct TorqueDemand<'a> {
    /// `R`, `[muscles x nv]`, row by row, m.
    pub moment_arms: &'a [f64],
    /// What gravity and motion need, `[nv]`, Nm.
    pub torque: &'a [f64],
}

/// A joint torque that no tensions within their limits give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueDeficit {
    /// The velocity of the robot with the most missing.
    pub velocity: usize,
    /// What is missing there, Nm or N.
    pub torque: f64,
    /// The muscle that would give most of it, and its tension, N, where one is at a limit.
    pub muscle: Option<(usize, f64)>,
}

/// Why a robot cannot be where or as fast as it is told.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Violation {
    /// The end point stays away from the path.
    Unreachable {
        /// Phase of the path, rad, or s of waypoints.
        phase: f64,
        /// By how much, m; 0 where the path closes and the joints do not.
        distance: f64,
    },
    /// A joint beyond its limits.
    JointRange {
        /// Its name.
        joint: String,
        /// rad or m.
        position: f64,
        /// rad or m.
        range: [f64; 2],
    },
    /// A joint too fast.
    JointSpeed {
        /// Its name.
        joint: String,
        /// rad/s or m/s.
        speed: f64,
        /// rad/s or m/s.
        most: f64,
    },
    /// A cable faster than its winch.
    CableSpeed {
        /// Its name.
        muscle: String,
        /// m/s.
        speed: f64,
        /// m/s.
        most: f64,
    },
    /// A cable whose speed changes faster than its winch's can.
    CableAcceleration {
        /// Its name.
        muscle: String,
        /// m/s^2.
        acceleration: f64,
        /// m/s^2.
        most: f64,
    },
    /// A torque out of the tensions' reach.
    Torque {
        /// Name of the joint.
        joint: String,
        /// What is needed, Nm or N.
        needed: f64,
        /// What is missing of it, Nm or N.
        missing: f64,
        /// The muscle that would give most of it, and its tension at its limit, N.
        muscle: Option<(String, f64)>,
    },
}

/// The first place of a trajectory where the robot cannot follow.
#[derive(Debug, Clone, PartialEq)]
pub struct Infeasibility {
    /// From the start, s.
    pub time: f64,
    /// What is in the way.
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
                write!(f, "joint `{joint}` must be within {low:.5} and {high:.5}, but is told {position:.5}")
            }
            Violation::JointSpeed { joint, speed, most } => {
                write!(f, "joint `{joint}` may move at most {most:.3} per s, but is told {speed:.3}")
            }
            Violation::CableSpeed { muscle, speed, most } => {
                write!(f, "the winch of `{muscle}` winds at most {most:.3} m/s, but is told {speed:.3}")
            }
            Violation::CableAcceleration { muscle, acceleration, most } => {
                write!(
                    f,
                    "the winch of `{muscle}` speeds up by at most {most:.3} m/s^2, but is told {acceleration:.3}"
                )
            }
            Violation::Torque { joint, needed, missing, muscle } => {
                write!(
                    f,
                    "`{joint}` needs {:.3} N m, and the tensions within their limits miss {:.3} of it",
                    needed.abs(),
                    missing.abs()
                )?;
                match muscle {
                    Some((muscle, tension)) => write!(f, " (`{muscle}` is at its limit of {tension:.0} N)"),
                    None => Ok(()),
                }
            }
        }
    }
}

/// Looks along a whole trajectory, start and end included, for the first place where the robot cannot follow. A path
/// that the end point leaves is an obstacle at any speed, and told before all others.
///
/// `reach` says whether tensions within their limits give a torque: the caller knows the limits and has the solver.
///
/// # Errors
/// [`Error::WrongLength`] where the trajectory is another robot's; [`Error::OutOfDomain`] for a limit that is not above
/// zero.
pub fn first_infeasibility(
    robot: &Robot,
    trajectory: &Trajectory,
    limits: &Limits,
    mut reach: impl FnMut(TorqueDemand<'_>) -> Result<Option<TorqueDeficit>, Error>,
) -> Result<Option<Infeasibility>, Error> {
    positive("joint_speed", limits.joint_speed)?;
    positive("cable_speed", limits.cable_speed)?;
    positive("cable_acceleration", limits.cable_acceleration)?;
    positive("interval", limits.interval)?;
    // Checked here: poses are looked at joint by joint below.
    check_length("joints of the trajectory", trajectory.joints(), robot.nq())?;
    check_length("joints of the trajectory", trajectory.joints(), robot.nv())?;
    if let Some((time, violation)) = first_miss(trajectory) {
        return Ok(Some(Infeasibility { time, violation }));
    }
    let muscles = Muscles::new(robot);
    let mut cables = Cables::new(robot, &muscles);
    let mut scratch = Scratch::new(robot);
    let mut now = Reference::new(trajectory.joints());
    let (mut torque, mut passive) = (vec![0.0; robot.nv()], vec![0.0; robot.nv()]);
    let mut arms = vec![0.0; muscles.count() * robot.nv()];
    // A limit of a million places: a trajectory of hours is looked at more coarsely.
    let places = libm::ceil(trajectory.duration() / limits.interval).min(1e6) as usize;
    for k in 0..=places {
        let time = trajectory.duration() * k as f64 / places.max(1) as f64;
        let stop = |violation| Ok(Some(Infeasibility { time, violation }));
        trajectory.sample(time, &mut now)?;
        if let Some(violation) = joints_cannot(robot, &now, limits) {
            return stop(violation);
        }
        if let Some(violation) = cables.cannot(robot, &now, limits)? {
            return stop(violation);
        }
        robot.inverse_dynamics(&now.q, &now.v, &now.a, &mut scratch, &mut torque)?;
        robot.passive_force(&now.q, &now.v, &mut passive)?;
        torque.iter_mut().zip(&passive).for_each(|(torque, passive)| *torque -= passive);
        muscles.dense(&cables.geometry, &mut arms)?;
        if let Some(short) = reach(TorqueDemand { moment_arms: &arms, torque: &torque })? {
            return stop(Violation::Torque {
                joint: joint_name(robot, short.velocity),
                needed: torque.get(short.velocity).copied().unwrap_or(f64::NAN),
                missing: short.torque,
                muscle: short.muscle.map(|(muscle, tension)| (muscle_name(robot, muscle), tension)),
            });
        }
    }
    Ok(None)
}

/// Looks at what the cables of a robot are told.
struct Cables<'a> {
    muscles: &'a Muscles,
    geometry: Geometry,
    soon: Reference,
    speeds: Vec<f64>,
    later: Vec<f64>,
}

/// Between two places whose cable speeds give their acceleration, s.
const SOON: f64 = 1e-5;

impl<'a> Cables<'a> {
    fn new(robot: &Robot, muscles: &'a Muscles) -> Self {
        Self {
            geometry: Geometry::new(robot, muscles),
            soon: Reference::new(robot.nv()),
            speeds: vec![0.0; muscles.count()],
            later: vec![0.0; muscles.count()],
            muscles,
        }
    }

    /// What no winch can follow; leaves the geometry of the pose.
    fn cannot(
        &mut self,
        robot: &Robot,
        now: &Reference,
        limits: &Limits,
    ) -> Result<Option<Violation>, Error> {
        for (k, q) in self.soon.q.iter_mut().enumerate() {
            *q = now.q[k] + SOON * now.v[k];
            self.soon.v[k] = now.v[k] + SOON * now.a[k];
        }
        self.muscles.evaluate(&self.soon.q, &mut self.geometry)?;
        self.muscles.velocities(&self.geometry, &self.soon.v, &mut self.later)?;
        self.muscles.evaluate(&now.q, &mut self.geometry)?;
        self.muscles.velocities(&self.geometry, &now.v, &mut self.speeds)?;
        for (m, (speed, later)) in self.speeds.iter().zip(&self.later).enumerate() {
            if speed.abs() > limits.cable_speed {
                let muscle = muscle_name(robot, m);
                let (speed, most) = (speed.abs(), limits.cable_speed);
                return Ok(Some(Violation::CableSpeed { muscle, speed, most }));
            }
            let acceleration = (later - speed).abs() / SOON;
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

/// What a pose at its limit may be beyond it, rad or m.
const ROUNDING: f64 = 1e-9;

fn joints_cannot(robot: &Robot, now: &Reference, limits: &Limits) -> Option<Violation> {
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let coordinates = robot.coordinates_of(index);
        if let (Some(range), 1) = (joint.range, coordinates.len()) {
            let position = now.q[coordinates.start];
            if position < range[0] - ROUNDING || position > range[1] + ROUNDING {
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

/// When the end point leaves the path, by the time law, and how.
fn first_miss(trajectory: &Trajectory) -> Option<(f64, Violation)> {
    let (joints, law) = match trajectory {
        Trajectory::AlongPath { joints, law } => (joints, law),
        Trajectory::PointToPoint(_) => return None,
        Trajectory::Sequence(motions) => {
            return motions.motions().find_map(|(start, motion)| {
                let (time, violation) = first_miss(motion)?;
                Some((start + time, violation))
            });
        }
    };
    let miss = joints.first_unreached()?;
    // The phase only rises: halving finds its time.
    let (mut time, mut late) = (0.0, law.duration());
    for _ in 0..60 {
        let middle = 0.5 * (time + late);
        if law.at(middle).phase < miss.phase { time = middle } else { late = middle }
    }
    Some((time, Violation::Unreachable { phase: miss.phase, distance: miss.distance }))
}
