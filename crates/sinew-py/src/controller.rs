//! The controller of a machine, one cycle at a time.

use crate::array::{Numbers, vector};
use crate::failure::Failure;
use numpy::PyArray1;
use pyo3::prelude::*;
use sinew::control::arm::{
    ActuationMode, ArmController, ArmMeasurement, ArmStatus, CableStateSource, PreviewedReference, synthesize,
};
use sinew::control::tension::Status;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Reference;
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::arm::CalibratedArm;
use sinew_lab::experiment::oracle_models;

/// Commands for the drives, with the intermediate results that led to them.
#[pyclass(frozen, module = "sinew")]
pub(crate) struct Command {
    speed: Vec<f64>,
    desired_tension: Vec<f64>,
    estimated_tension: Vec<f64>,
    q: Vec<f64>,
    reached: bool,
    status: ArmStatus,
}

#[pymethods]
impl Command {
    /// Speeds of the cables at the winches, m/s, positive toward the motor, shape `(muscles,)`.
    #[getter]
    fn speed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.speed)
    }

    /// Desired tensions at the anchors, N, shape `(muscles,)`.
    #[getter]
    fn desired_tension<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.desired_tension)
    }

    /// Estimated tensions at the anchors, N, shape `(muscles,)`.
    #[getter]
    fn estimated_tension<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.estimated_tension)
    }

    /// Estimated pose, rad or m, shape `(joints,)`.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.q)
    }

    /// Whether the desired tensions give the desired torque.
    #[getter]
    fn reached(&self) -> bool {
        self.reached
    }

    /// `"following"`, `"holding"`, `"degraded"` or `"stopped"`.
    #[getter]
    fn status(&self) -> &'static str {
        match self.status {
            ArmStatus::Following => "following",
            ArmStatus::Holding => "holding",
            ArmStatus::Degraded(_) => "degraded",
            ArmStatus::Stopped(_) => "stopped",
        }
    }

    /// The fault that degraded or stopped the machine, with the index of its joint or muscle.
    #[getter]
    fn fault(&self) -> Option<String> {
        match self.status {
            ArmStatus::Degraded(fault) | ArmStatus::Stopped(fault) => Some(format!("{fault:?}")),
            _ => None,
        }
    }
}

/// The controller of a machine: observers, inverse dynamics, distribution of tensions, winch commands.
///
/// Made by `Machine.controller`.
#[pyclass(module = "sinew")]
pub(crate) struct Controller {
    inner: ArmController,
    muscles: usize,
    period_s: f64,
    current: Reference,
    previewed: Reference,
}

impl Controller {
    /// With cables as designed, or identified on the bench of the specimen of a seed; gains for these poses.
    pub(crate) fn new(machine: &Machine, seed: Option<u64>, poses: &[Vec<f64>]) -> Result<Self, Failure> {
        let (machine, models) = match seed {
            Some(seed) => {
                let arm = CalibratedArm::new(machine, seed)?;
                (arm.machine, arm.models)
            }
            None => (machine.loaded()?, oracle_models(&ArmSpecimen::nominal(machine)?)),
        };
        Self::from_models(&machine, &models, poses)
    }

    fn from_models(machine: &Machine, models: &[CableModel], poses: &[Vec<f64>]) -> Result<Self, Failure> {
        let (gains, _) = synthesize(machine, models, poses)?;
        let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let inner = ArmController::new(&machine.robot, models, gains, mode)?;
        let joints = machine.start.len();
        Ok(Self {
            inner: inner.with_sheath_bends(&machine.sheath_bends()?)?,
            muscles: machine.muscles.len(),
            period_s: machine.period,
            current: Reference::new(joints),
            previewed: Reference::new(joints),
        })
    }
}

/// Pose, velocity and acceleration as Python gives them.
type Motion<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Fills a reference; velocity and acceleration are zero where they are not given.
fn set(to: &mut Reference, q: &Bound<'_, PyAny>, rates: [Option<&Bound<'_, PyAny>>; 2]) -> PyResult<()> {
    let joints = to.q.len();
    to.q.copy_from_slice(Numbers::from_python(q, "q")?.row("q", joints)?);
    for (to, (name, given)) in [&mut to.v, &mut to.a].into_iter().zip(["v", "a"].into_iter().zip(rates)) {
        match given {
            Some(given) => to.copy_from_slice(Numbers::from_python(given, name)?.row(name, joints)?),
            None => to.fill(0.0),
        }
    }
    Ok(())
}

#[pymethods]
impl Controller {
    /// One control cycle: the commands for the `interval_s` seconds to come, by default a period of the
    /// machine.
    ///
    /// Measured: `motor`, positions of the cables at the motors, m, and `tension` at the drives, N, shapes
    /// `(muscles,)`; `joint`, the joints' encoders, rad or m, shape `(joints,)`, not read where a joint has
    /// none. Reference: `q`, and `v` and `a`, zero by default, shapes `(joints,)`, rad or m, per s, per s^2;
    /// `previewed`, the same as a tuple `(q, v, a)` 0.12 s ahead, by default the present one.
    #[pyo3(signature = (motor, tension, joint, q, v=None, a=None, *, previewed=None, interval_s=None))]
    #[expect(clippy::too_many_arguments, reason = "one per sensor and reference")]
    #[expect(clippy::needless_pass_by_value, reason = "a tuple is extracted, not borrowed")]
    fn step(
        &mut self,
        motor: &Bound<'_, PyAny>,
        tension: &Bound<'_, PyAny>,
        joint: &Bound<'_, PyAny>,
        q: &Bound<'_, PyAny>,
        v: Option<&Bound<'_, PyAny>>,
        a: Option<&Bound<'_, PyAny>>,
        previewed: Option<Motion<'_>>,
        interval_s: Option<f64>,
    ) -> PyResult<Command> {
        let interval_s = interval_s.unwrap_or(self.period_s);
        if !(1e-5..=0.02).contains(&interval_s) {
            let expected = "interval_s must be a number of seconds in [1e-5, 0.02]";
            return Err(Failure::refused(format!("{expected}, but is {interval_s}")).into());
        }
        let (motor, tension) =
            (Numbers::from_python(motor, "motor")?, Numbers::from_python(tension, "tension")?);
        let joint = Numbers::from_python(joint, "joint")?;
        set(&mut self.current, q, [v, a])?;
        match &previewed {
            Some((q, v, a)) => set(&mut self.previewed, q, [Some(v), Some(a)])?,
            None => self.previewed.clone_from(&self.current),
        }
        let Self { inner, muscles, current, previewed, .. } = self;
        let measurement = ArmMeasurement {
            motor: motor.row("motor", *muscles)?,
            tension: tension.row("tension", *muscles)?,
            joint: joint.row("joint", current.q.len())?,
        };
        let reference = PreviewedReference { current, previewed, repeat_time: None };
        let command = inner.step(interval_s, &measurement, &reference).map_err(Failure::from)?;
        let speed = |drive: &DriveCommand| match drive {
            DriveCommand::Velocity(speed) => *speed,
            _ => f64::NAN,
        };
        Ok(Command {
            speed: command.drives.iter().map(speed).collect(),
            desired_tension: command.desired_tension.to_vec(),
            estimated_tension: command.estimated_tension.to_vec(),
            q: command.q.to_vec(),
            reached: command.distribution == Status::Optimal,
            status: command.status,
        })
    }

    /// A controller that continues independently from the same state.
    fn copy(&self) -> Self {
        Self {
            inner: self.inner.clone(),
            muscles: self.muscles,
            period_s: self.period_s,
            current: self.current.clone(),
            previewed: self.previewed.clone(),
        }
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.copy()
    }
}
