use super::inverse_kinematics::{POSITION_TOLERANCE, Solver};
use super::path::EndPointPath;
use crate::error::Error;
use crate::random::EvenPoints;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

/// The first point of a path that the joints do not reach.
#[derive(Debug, Clone, PartialEq)]
pub struct UnreachedPoint {
    /// Phase of the first point: rad on a closed path, approximately s between waypoints.
    pub phase: f64,
    /// Largest distance, m, between the rest of the path and the closest point that is reached; 0 where the
    /// joints stop for another reason.
    pub distance: f64,
    /// Why.
    pub cause: UnreachedCause,
}

/// Why the joints do not follow a path.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum UnreachedCause {
    /// The point lies outside of the workspace, also without the joints' ranges.
    OutsideWorkspace,
    /// The ranges of these joints keep the end point away.
    JointRanges(Vec<String>),
    /// Only in a singular pose is the end point this close: there the joints' velocities would be infinite.
    Singular,
    /// The point can be reached, but not continuously from the pose before it; these joints are then at the
    /// limits of their ranges.
    OtherPose(Vec<String>),
    /// The path closes and the joints do not.
    NotClosed,
    /// Fewer motors than joints: at these lengths of the cables the springs do not hold the others.
    Snaps {
        /// Name of the joint that moves most.
        joint: String,
        /// Least stiffness of the joints at constant lengths, Nm/rad or N/m.
        stiffness: f64,
    },
}

impl fmt::Display for UnreachedPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { phase, distance, cause } = self;
        let beyond = format_args!(
            "target unreachable, missed by up to {} mm from phase {phase:.3} on",
            Millimetres(*distance)
        );
        match cause {
            UnreachedCause::OutsideWorkspace => write!(f, "{beyond}: it lies outside of the workspace"),
            UnreachedCause::JointRanges(joints) => {
                let limits =
                    if joints.len() == 1 { "the limit of its range" } else { "the limits of their ranges" };
                write!(f, "{beyond}: {} at {limits}", Names(joints))
            }
            UnreachedCause::Singular => write!(f, "{beyond}: the pose there is singular"),
            UnreachedCause::OtherPose(joints) if joints.is_empty() => {
                write!(f, "the joints cannot follow the path continuously (phase {phase:.3})")
            }
            UnreachedCause::OtherPose(joints) => {
                let limits = "at the limit of its range";
                let place = format_args!("the joints cannot follow the path continuously (phase {phase:.3})");
                write!(f, "{place}: {} {limits}", Names(joints))
            }
            UnreachedCause::NotClosed => {
                write!(f, "the path closes, but the joints do not (phase {phase:.3})")
            }
            UnreachedCause::Snaps { joint, stiffness } => write!(
                f,
                "fewer motors than joints, and `{joint}` does not follow the lengths of its cables but snaps: \
                    the springs leave it a stiffness of {stiffness:.2e} Nm/rad (phase {phase:.3})"
            ),
        }
    }
}

/// A length, m, in mm with one decimal, or two significant digits below 1 mm.
struct Millimetres(f64);

impl fmt::Display for Millimetres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 >= 1e-3 { write!(f, "{:.1}", 1e3 * self.0) } else { write!(f, "{:.1e}", 1e3 * self.0) }
    }
}

/// Quoted names between commas.
struct Names<'a>(&'a [String]);

impl fmt::Display for Names<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, name) in self.0.iter().enumerate() {
            write!(f, "{}`{name}`", if k > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

/// Position error up to which a point counts as reached in a singular pose, m.
const SINGULAR_TOLERANCE: f64 = 1e-5;

/// Points between the first one that is not reached and the end of the path, of which the farthest explains.
const POINTS: usize = 24;

/// Why a path is not followed from a phase on, from a pose nearby.
pub(super) fn explain(
    solver: &mut Solver<'_>,
    path: &EndPointPath,
    phase: f64,
    near: &[f64],
) -> Result<UnreachedPoint, Error> {
    let mut stuck = near.to_vec();
    let from_near = solver.reach(path.point(phase), &mut stuck)?;
    let held = joints_at_limits(solver, path.point(phase), &stuck)?;
    let mut farthest = (path.point(phase), stuck.clone(), from_near);
    let mut x = stuck.clone();
    for k in 1..=POINTS {
        let target = path.point(phase + (path.length() - phase) * k as f64 / POINTS as f64);
        let distance = solver.reach(target, &mut x)?;
        if distance > farthest.2 {
            farthest = (target, x.clone(), distance);
        }
    }
    let (target, first, distance) = farthest;
    let (distance, closest) = closest(solver, target, &first, distance)?;
    if distance <= POSITION_TOLERANCE {
        let joints = if held.is_empty() { ranges_touched(solver, &stuck) } else { held };
        return Ok(UnreachedPoint { phase, distance: 0.0, cause: UnreachedCause::OtherPose(joints) });
    }
    let cause = if free_distance(solver, target, &closest)? <= SINGULAR_TOLERANCE {
        let joints = joints_at_limits(solver, target, &closest)?;
        if joints.is_empty() { UnreachedCause::Singular } else { UnreachedCause::JointRanges(joints) }
    } else {
        UnreachedCause::OutsideWorkspace
    };
    Ok(UnreachedPoint { phase, distance, cause })
}

/// The closest pose from many starts, and its position error, m.
fn closest(
    solver: &mut Solver<'_>,
    target: [f64; 3],
    first: &[f64],
    distance: f64,
) -> Result<(f64, Vec<f64>), Error> {
    let mut best = (distance, first.to_vec());
    for k in 0..STARTS {
        if best.0 <= POSITION_TOLERANCE {
            break;
        }
        let mut x = start(solver, k);
        let distance = solver.reach(target, &mut x)?;
        if distance < best.0 {
            best = (distance, x);
        }
    }
    Ok(best)
}

/// The position error, m, that remains where no joint has a range.
fn free_distance(solver: &Solver<'_>, target: [f64; 3], closest: &[f64]) -> Result<f64, Error> {
    let mut free = solver.without_ranges();
    let mut x = closest.to_vec();
    let mut best = free.reach(target, &mut x)?;
    for k in 0..STARTS {
        if best <= POSITION_TOLERANCE {
            break;
        }
        let mut x = start(solver, k);
        best = best.min(free.reach(target, &mut x)?);
    }
    Ok(best)
}

/// Names of the joints at a limit beyond which the end point would come closer.
fn joints_at_limits(solver: &mut Solver<'_>, target: [f64; 3], x: &[f64]) -> Result<Vec<String>, Error> {
    let error = solver.error(target, x)?;
    let (n, length) = (x.len(), crate::body::vector::norm(error));
    let pull = |i: usize| (0..3).map(|k| solver.kinematics.rows[k * n + i] * error[k]).sum::<f64>();
    let lever = |i: usize| {
        libm::sqrt((0..3).map(|k| solver.kinematics.rows[k * n + i]).map(|entry| entry * entry).sum::<f64>())
    };
    let holds = |i: usize| {
        let [low, high] = solver.ranges[i];
        let least = 1e-6 * lever(i) * length;
        (x[i] <= low && pull(i) < -least) || (x[i] >= high && pull(i) > least)
    };
    Ok(names(solver, (0..n).filter(|&i| holds(i))))
}

/// Names of the joints at a limit.
fn ranges_touched(solver: &Solver<'_>, x: &[f64]) -> Vec<String> {
    let touched = |i: &usize| x[*i] <= solver.ranges[*i][0] || x[*i] >= solver.ranges[*i][1];
    names(solver, (0..x.len()).filter(touched))
}

fn names(solver: &Solver<'_>, joints: impl Iterator<Item = usize>) -> Vec<String> {
    let independent = solver.robot.independent_joints();
    joints.map(|i| solver.robot.parts().joints[independent[i]].name.clone()).collect()
}

/// Number of starts of a search.
pub(super) const STARTS: usize = 64;

/// A start of a search: the rest pose, then points spread evenly over the ranges.
pub(super) fn start(solver: &Solver<'_>, k: usize) -> Vec<f64> {
    let mut x = solver.rest();
    let Some(point) = k.checked_sub(1).and_then(|k| EvenPoints::new(x.len()).nth(k)) else { return x };
    for ((x, range), fraction) in x.iter_mut().zip(&solver.ranges).zip(point) {
        let [low, high] = match *range {
            [low, high] if low.is_finite() && high.is_finite() => [low, high],
            [low, high] => [low.max(*x - UNLIMITED), high.min(*x + UNLIMITED)],
        };
        *x = low + (high - low) * fraction;
    }
    x
}

/// Half of the width in which an unlimited joint starts, rad or m.
const UNLIMITED: f64 = 3.0;
