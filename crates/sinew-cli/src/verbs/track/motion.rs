//! `--path`, resolved for a machine: a desired motion of its end point or of its joints.

use super::{joints, waypoints};
use crate::arguments::{PATH_FORMS, PathArgument};
use crate::error::Error;
use sinew::machine::Machine;
use sinew::trajectory::{Infeasibility, Trajectory, Violation};
use sinew_lab::arm::{DesiredMotion, first_infeasibility, infeasible_motion, plan, plan_tour};

/// The path of a machine where none is given: its first one by name, else a tour.
pub(super) fn default_path(machine: &Machine) -> PathArgument {
    machine.paths.first().map_or(PathArgument::Tour, |first| PathArgument::Named(first.name.clone()))
}

/// Plans the trajectory of a path.
pub(crate) fn trajectory(
    machine: &Machine,
    path: &PathArgument,
    duration: Option<f64>,
) -> Result<Trajectory, Error> {
    let Some(motion) = desired(machine, path)? else {
        let check = |trajectory: &Trajectory| first_infeasibility(machine, trajectory, 1);
        return Ok(plan_tour(machine, duration, check)?);
    };
    if motion.needs_end_point() && machine.task.site().is_none() {
        let value = path.to_string();
        let expected =
            "a motion of the joints (tour, to-joints: or joints:), because the machine has no end point";
        return Err(Error::Argument { flag: "--path", value, expected });
    }
    if let Some(given) = duration.filter(|_| motion.has_times()) {
        let expected = "none with waypoints, which have their own times";
        return Err(Error::Argument { flag: "--duration", value: given.to_string(), expected });
    }
    Ok(plan(machine, &motion, duration)?)
}

/// A duration, s, with which a motion is feasible that is too fast as `planned` for so many repeats; none
/// where more time does not help, or it has times of its own.
pub(super) fn long_enough(
    machine: &Machine,
    path: &PathArgument,
    (planned, repeats): (&Trajectory, u32),
    infeasibility: &Infeasibility,
) -> Result<Option<f64>, Error> {
    if desired(machine, path)?.is_some_and(|motion| motion.has_times()) {
        return Ok(None);
    }
    let (mut duration, mut violation) = (planned.duration(), infeasibility.violation.clone());
    for _ in 0..ATTEMPTS {
        let slower = match violation {
            Violation::JointSpeed { speed, most, .. } | Violation::CableSpeed { speed, most, .. } => {
                speed / most
            }
            Violation::CableAcceleration { acceleration, most, .. } => (acceleration / most).sqrt(),
            _ => return Ok(None),
        };
        duration = (10.0 * duration * slower.max(LEAST_STEP)).ceil() / 10.0;
        if duration.is_nan() || duration > LONGEST_S {
            return Ok(None);
        }
        match infeasible_motion(machine, &unchecked(machine, path, duration)?, repeats)? {
            None => return Ok(Some(duration)),
            Some(found) => violation = found.infeasibility.violation,
        }
    }
    Ok(None)
}

/// Durations that are tried, the least ratio between two of them, and the longest, s.
const ATTEMPTS: usize = 10;
const LEAST_STEP: f64 = 1.15;
const LONGEST_S: f64 = 3600.0;

/// The same without a look at what the muscles can do; tours take the duration.
pub(crate) fn unchecked(machine: &Machine, path: &PathArgument, duration: f64) -> Result<Trajectory, Error> {
    match desired(machine, path)? {
        None => Ok(plan_tour(machine, Some(duration), |_| Ok(None))?),
        Some(motion) => Ok(plan(machine, &motion, Some(duration))?),
    }
}

/// The motion, or none for a tour.
fn desired(machine: &Machine, path: &PathArgument) -> Result<Option<DesiredMotion>, Error> {
    Ok(Some(match path {
        PathArgument::Tour => return Ok(None),
        PathArgument::Named(name) => {
            let named = machine.paths.iter().find(|named| named.name == *name);
            let known =
                || machine.paths.iter().map(|named| named.name.clone()).chain([PATH_FORMS.to_owned()]);
            let unknown = || Error::unknown("--path", name, "path", known().collect());
            DesiredMotion::ClosedPath(named.ok_or_else(unknown)?.path.clone())
        }
        PathArgument::Point(position) => DesiredMotion::ToPoint(*position),
        PathArgument::Pose(joints) => DesiredMotion::ToPose(joints::pose(machine, joints)?),
        PathArgument::Waypoints(file) => DesiredMotion::Waypoints(waypoints::read(file)?),
        PathArgument::JointWaypoints(file) => DesiredMotion::JointWaypoints(joints::read(machine, file)?),
    }))
}
