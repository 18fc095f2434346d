//! Motions of a machine: planned, and tracked by its simulated twin.

use crate::array::{Numbers, array};
use crate::failure::Failure;
use crate::long_call;
use crate::machine::Machine;
use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};
use sinew::machine::ControlRules;
use sinew::trajectory::{Approach, JointWaypoint, Reference, Waypoint};
use sinew::twin::arm::InjectedFault;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, DesiredMotion, INITIAL_REST_S, InfeasibleMotion, TraceRow, TrackingTask, Verified,
    VerifiedMotion, WrittenFault, first_infeasibility, infeasible_motion, plan, plan_tour, track_arm,
    verify as simulate_sampled_machines,
};
use std::sync::Arc;

/// A reference of the joints over time, from rest to rest.
///
/// Made by `Machine.plan`.
#[pyclass(frozen, module = "sinew")]
pub(crate) struct Trajectory {
    pub(crate) inner: Arc<sinew::trajectory::Trajectory>,
}

/// Array of numbers as it is returned.
type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

#[pymethods]
impl Trajectory {
    /// From rest to rest, s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.inner.duration()
    }

    /// Whether it ends in its initial pose.
    #[getter]
    fn closed(&self) -> bool {
        self.inner.is_closed()
    }

    /// Pose, velocity and acceleration, rad or m, per s, per s^2, shapes `(..., joints)`.
    ///
    /// `time_s`: time, s, any shape; at rest before 0 and after the end.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        time_s: &Bound<'py, PyAny>,
    ) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
        let time = Numbers::from_python(time_s, "time_s")?;
        let (lead, time) = (time.shape().to_vec(), time.slice()?);
        if let Some(wrong) = time.iter().find(|t| !t.is_finite()) {
            return Err(Failure::refused(format!("time_s must be finite, but is {wrong}")).into());
        }
        let n = self.inner.joints();
        let (mut q, mut v, mut a) = (Vec::new(), Vec::new(), Vec::new());
        let mut at = Reference::new(n);
        long_call::for_each(py, time.len(), |k| {
            self.inner.sample(time[k], &mut at)?;
            q.extend_from_slice(&at.q);
            v.extend_from_slice(&at.v);
            a.extend_from_slice(&at.a);
            Ok(())
        })?;
        Ok((array(py, q, &lead, &[n])?, array(py, v, &lead, &[n])?, array(py, a, &lead, &[n])?))
    }
}

/// A desired motion as the Python face gives it.
#[derive(FromPyObject)]
pub(crate) enum Desired {
    #[pyo3(transparent)]
    Named(String),
    Point {
        #[pyo3(item)]
        point: [f64; 3],
    },
    Pose {
        #[pyo3(item)]
        pose: Vec<f64>,
    },
    Waypoints {
        #[pyo3(item)]
        waypoints: Vec<(f64, [f64; 3])>,
    },
    JointWaypoints {
        #[pyo3(item)]
        joint_waypoints: Vec<(f64, Vec<f64>)>,
    },
}

impl Desired {
    /// The motion, or none for a tour.
    fn motion(self, machine: &sinew::machine::Machine) -> Result<Option<DesiredMotion>, Failure> {
        Ok(Some(match self {
            Self::Named(name) if name == "tour" => return Ok(None),
            Self::Named(name) => {
                let found = machine.paths.iter().find(|path| path.name == name);
                let known = machine.paths.iter().map(|path| path.name.as_str()).chain(["tour"]);
                let known = known.collect::<Vec<_>>().join(", ");
                let unknown = || Failure::refused(format!("path must be one of {known}, but is {name:?}"));
                DesiredMotion::ClosedPath(found.ok_or_else(unknown)?.path.clone())
            }
            Self::Point { point } => DesiredMotion::ToPoint(point),
            Self::Pose { pose } => DesiredMotion::ToPose(pose),
            Self::Waypoints { waypoints } => {
                let point = |(time, position)| Waypoint { time, position };
                DesiredMotion::Waypoints(waypoints.into_iter().map(point).collect())
            }
            Self::JointWaypoints { joint_waypoints } => {
                let point = |(time, q)| JointWaypoint { time, q };
                DesiredMotion::JointWaypoints(joint_waypoints.into_iter().map(point).collect())
            }
        }))
    }
}

/// Plans a motion; see `Machine.plan`.
#[pyfunction]
pub(crate) fn plan_motion(
    py: Python<'_>,
    machine: &Machine,
    desired: Desired,
    duration_s: Option<f64>,
) -> PyResult<Trajectory> {
    let machine = machine.machine.clone();
    let inner = long_call::run(py, None, None, move |_| {
        if duration_s.is_some_and(|d| !d.is_finite()) {
            return Err(Failure::refused("duration_s must be a finite number of seconds"));
        }
        Ok(match desired.motion(&machine)? {
            None => plan_tour(&machine, duration_s, |t| first_infeasibility(&machine, t, 1))?,
            Some(motion) if motion.has_times() && duration_s.is_some() => {
                return Err(Failure::refused(
                    "duration_s must be none with waypoints, which have their own times",
                ));
            }
            Some(motion) => plan(&machine, &motion, duration_s)?,
        })
    })?;
    Ok(Trajectory { inner: Arc::new(inner) })
}

/// How a motion is tracked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Conditions {
    repeats: Option<u32>,
    learning: bool,
    hold_s: f64,
    compensation: String,
    payload_kg: Option<f64>,
    faults: Vec<String>,
    seed: u64,
    unverified: bool,
    /// Of `verify`, as JSON.
    rules: Option<String>,
    trace_interval_s: f64,
}

/// Rules with which sampled machines track a motion, as JSON, and a warning where they do so inaccurately;
/// see `sinew.verify`.
#[pyfunction]
pub(crate) fn verify(
    py: Python<'_>,
    machine: &Machine,
    trajectory: &Trajectory,
    repeats: Option<u32>,
    payload_kg: Option<f64>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Option<String>)> {
    let (machine, trajectory) = (machine.machine.clone(), trajectory.inner.clone());
    long_call::run(py, progress, None, move |progress| {
        let machine = loaded(&machine, payload_kg)?;
        let repeats = number_of_repeats(repeats, trajectory.is_closed())?;
        progress.tell("checking and verifying the motion", 0.0);
        check_feasible(&machine, &trajectory, repeats)?;
        let (rules, warning, errors) = verified(&machine, &trajectory, repeats, false)?;
        let mut rules = serde_json::to_value(rules)?;
        if let Some(rules) = rules.as_object_mut() {
            rules.extend(error_names(&machine).zip(errors).map(|(name, error)| (name, error.into())));
        }
        Ok((rules.to_string(), warning))
    })
}

/// Under which the rules of `verify` have the largest error of every independent joint, by which a run is
/// judged.
fn error_names(machine: &sinew::machine::Machine) -> impl Iterator<Item = String> {
    let joints = machine.robot.independent_joints().into_iter();
    joints.map(|joint| format!("joint_error:{}", machine.robot.parts().joints[joint].name))
}

/// Rules with which sampled machines track a motion, a warning where they do so inaccurately, and the largest
/// errors of their joints. Where none do, a refusal, or the machine's own rules if it is to be started
/// nevertheless.
fn verified(
    machine: &sinew::machine::Machine,
    trajectory: &sinew::trajectory::Trajectory,
    repeats: u32,
    start_nevertheless: bool,
) -> Result<(ControlRules, Option<String>, Vec<f64>), Failure> {
    let VerifiedMotion { verified, joint_errors, .. } =
        simulate_sampled_machines(machine, trajectory, repeats)?;
    match verified {
        Verified::Tracks(rules) => Ok((rules, None, joint_errors)),
        Verified::Inaccurate(rules, reason) => {
            let start = "simulated machines of this design come to the end of this motion, but not well";
            Ok((rules, Some(format!("{start}: {reason}")), joint_errors))
        }
        Verified::Fails(_) if start_nevertheless => Ok((machine.rules, None, joint_errors)),
        Verified::Fails(reason) => Err(Failure::refused(format!(
            "simulated machines of this design do not track this motion: {reason}; a slower motion may help, \
                and unverified=True starts it nevertheless"
        ))),
    }
}

/// The machine with a payload, by default its own.
fn loaded(
    machine: &sinew::machine::Machine,
    payload_kg: Option<f64>,
) -> Result<sinew::machine::Machine, Failure> {
    let payload = payload_kg.unwrap_or(machine.payload);
    let machine = sinew::machine::Machine { payload, ..machine.clone() };
    machine.validate()?;
    Ok(machine)
}

/// Tracks a motion; see `sinew.track`. Numbers as JSON, the trace as columns, and what to warn of.
#[pyfunction]
pub(crate) fn track<'py>(
    py: Python<'py>,
    machine: &Machine,
    trajectory: &Trajectory,
    conditions: Conditions,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>, Option<String>)> {
    let (machine, trajectory) = (machine.machine.clone(), trajectory.inner.clone());
    let (numbers, trace, warning) = long_call::run(py, progress, None, move |progress| {
        let variant: CompensationVariant = conditions.compensation.parse()?;
        for (name, value) in
            [("hold_s", conditions.hold_s), ("trace_interval_s", conditions.trace_interval_s)]
        {
            if !(0.0..=3600.0).contains(&value) {
                return Err(Failure::refused(format!("{name} must be 0 to 3600 s, but is {value}")));
            }
        }
        let mut machine = loaded(&machine, conditions.payload_kg)?;
        let repeats = number_of_repeats(conditions.repeats, trajectory.is_closed())?;
        let faults = injected(&conditions, &machine, &trajectory, repeats)?;
        progress.tell("checking and verifying the motion", 0.0);
        check_feasible(&machine, &trajectory, repeats)?;
        let (mut warning, mut normal_errors) = (None, Vec::new());
        if let Some(rules) = &conditions.rules {
            let refused = |error| Failure::refused(format!("rules must be those of `verify`: {error}"));
            let mut rules: Map<String, Value> =
                serde_json::from_str(rules).map_err(|error| refused(error.to_string()))?;
            let errors =
                error_names(&machine).map(|name| rules.remove(&name).and_then(|error| error.as_f64()));
            normal_errors = errors.collect::<Option<Vec<f64>>>().unwrap_or_default();
            machine.rules =
                serde_json::from_value(rules.into()).map_err(|error| refused(error.to_string()))?;
            machine.validate()?;
        } else if variant == CompensationVariant::Observer {
            (machine.rules, warning, normal_errors) =
                verified(&machine, &trajectory, repeats, conditions.unverified)?;
        }
        progress.tell("calibrating the cables", 0.2);
        let arm = CalibratedArm::new(&machine, conditions.seed)?.with_normal_errors(normal_errors);
        progress.tell("tracking", 0.4);
        let task = TrackingTask {
            trajectory: &trajectory,
            repeats,
            learning: conditions.learning,
            final_rest: conditions.hold_s,
            faults: &faults,
            gains: None,
            trace_interval: conditions.trace_interval_s,
        };
        let result = track_arm(&arm, variant, &task)?;
        Ok((serde_json::to_string(&result.numbers)?, result.trace, warning))
    })?;
    Ok((numbers, columns(py, &trace)?, warning))
}

/// The faults of the machine, all of which begin before the run is over.
fn injected(
    conditions: &Conditions,
    machine: &sinew::machine::Machine,
    trajectory: &sinew::trajectory::Trajectory,
    repeats: u32,
) -> Result<Vec<InjectedFault>, Failure> {
    let approach = Approach::new(&machine.robot, trajectory, &machine.standing(trajectory)?)?;
    let motion_s = f64::from(repeats) * trajectory.duration();
    let end_s = approach.duration() + INITIAL_REST_S + motion_s + conditions.hold_s;
    let fault = |text: &String| {
        let written: WrittenFault =
            text.parse().map_err(|error| Failure::refused(format!("faults: {text:?}: {error}")))?;
        written.begins_before(end_s).map_err(|error| Failure::refused(format!("faults: {error}")))?;
        written.of(machine).map_err(|error| Failure::refused(format!("faults: {error}")))
    };
    conditions.faults.iter().map(fault).collect()
}

/// An open motion is tracked once.
fn number_of_repeats(given: Option<u32>, closed: bool) -> Result<u32, Failure> {
    match given {
        Some(0) => Err(Failure::refused("repeats must be at least 1")),
        _ if closed => Ok(given.unwrap_or(1)),
        None | Some(1) => Ok(1),
        Some(many) => Err(Failure::refused(format!(
            "repeats must be 1 for a motion that does not end where it begins, but is {many}"
        ))),
    }
}

/// Longest motion that is simulated, s: that of the program's `--duration`.
const LONGEST_S: f64 = 3600.0;

/// Refuses a motion that the machine cannot carry out, or whose simulation would take hours.
fn check_feasible(
    machine: &sinew::machine::Machine,
    trajectory: &sinew::trajectory::Trajectory,
    repeats: u32,
) -> Result<(), Failure> {
    let duration = trajectory.duration();
    if duration > LONGEST_S {
        return Err(Failure::refused(format!(
            "the motion must take at most {LONGEST_S} s, but takes {duration} s"
        )));
    }
    let Some(InfeasibleMotion { payload, infeasibility }) = infeasible_motion(machine, trajectory, repeats)?
    else {
        return Ok(());
    };
    let load = if payload > 0.0 { format!(" with {payload} kg") } else { String::new() };
    Err(Failure::refused(format!("the machine cannot track the motion{load}: {infeasibility}")))
}

fn columns<'py>(py: Python<'py>, trace: &[TraceRow]) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("time_s", PyArray1::from_vec(py, trace.iter().map(|row| row.time_s).collect()))?;
    let repeat = |row: &TraceRow| row.repeat.map_or(-1, i64::from);
    result.set_item("repeat", PyArray1::from_vec(py, trace.iter().map(repeat).collect()))?;
    let names = trace.first().into_iter().flat_map(TraceRow::columns);
    for (k, (name, first)) in names.enumerate() {
        let numbers = trace.iter().filter_map(|row| row.columns().nth(k)).flat_map(|(_, numbers)| numbers);
        result.set_item(name, array(py, numbers.copied().collect(), &[trace.len()], &[first.len()])?)?;
    }
    Ok(result)
}
