//! The simulated machine: the plant that a controller meets.

use crate::array::{Numbers, vector};
use crate::failure::Failure;
use crate::machine::Machine;
use numpy::PyArray1;
use pyo3::prelude::*;
use sinew::control::arm::resting_tensions;
use sinew::drive::DriveCommand;
use sinew::twin::arm::{ArmSpecimen, ArmTwin};

/// Array of numbers as it is returned.
type Vector<'py> = Bound<'py, PyArray1<f64>>;

/// A simulated machine: bodies, elastic cables with friction and effects that no model has, drives, sensors.
///
/// `seed` draws a specimen within the machine's tolerances; without it the machine is as designed, and `seed`
/// 0 that of the sensor noise. It starts at rest in the pose `q`, rad or m, shape `(joints,)`, by default the
/// machine's start, with `tension_n` at the anchors, N, shape `(muscles,)`, by default such that gravity is
/// in equilibrium. Everything is simulated.
#[pyclass(module = "sinew")]
pub(crate) struct Twin {
    inner: ArmTwin,
    commands: Vec<DriveCommand>,
}

/// The specimen of a seed with the payload of its machine; without a seed the machine as designed.
pub(crate) fn specimen(machine: &sinew::machine::Machine, seed: Option<u64>) -> Result<ArmSpecimen, Failure> {
    let design = ArmSpecimen::nominal(machine)?;
    let specimen = match seed {
        Some(seed) => ArmSpecimen::sampled_around(&design, machine, seed)?,
        None => design,
    };
    Ok(match machine.payload_site() {
        Some(site) if machine.payload > 0.0 => {
            let site = &machine.robot.parts().sites[site];
            specimen.with_payload(site.body, site.position, machine.payload)?
        }
        _ => specimen,
    })
}

/// A specimen at rest in a pose, with these tensions at the anchors, or such that gravity is in equilibrium
/// within the limits.
pub(crate) fn at_rest(
    machine: &sinew::machine::Machine,
    seed: Option<u64>,
    q: &[f64],
    tension: Option<&[f64]>,
    limits: &[[f64; 2]],
) -> Result<ArmTwin, Failure> {
    let specimen = specimen(machine, seed)?;
    let seed = seed.unwrap_or(0);
    Ok(match tension {
        Some(tension) => ArmTwin::new(&specimen, q, tension, seed)?,
        None => ArmTwin::new(&specimen, q, &resting_tensions(&specimen.robot, q, limits)?, seed)?,
    })
}

/// Limits of the tensions between which [`at_rest`] chooses; none where it is given tensions.
pub(crate) fn limits(machine: &sinew::machine::Machine, given: bool) -> Result<Vec<[f64; 2]>, Failure> {
    Ok(if given { Vec::new() } else { Machine::design_gains(machine)?.tension_limits() })
}

/// The command of a number.
pub(crate) fn command_of(kind: &str) -> Result<fn(f64) -> DriveCommand, Failure> {
    match kind {
        "speed" => Ok(DriveCommand::Velocity),
        "current" => Ok(DriveCommand::Current),
        "tension" => Ok(|tension| DriveCommand::Tension { tension, feed: 0.0 }),
        other => {
            let expected = "kind must be \"speed\", \"tension\" or \"current\"";
            Err(Failure::refused(format!("{expected}, but is {other:?}")))
        }
    }
}

impl Twin {
    /// One that goes on from the state of a machine.
    pub(crate) fn of(inner: ArmTwin) -> Self {
        Self { commands: vec![DriveCommand::Off; inner.specimen().drives.len()], inner }
    }
}

#[pymethods]
impl Twin {
    #[new]
    #[pyo3(signature = (machine, seed=None, *, q=None, tension_n=None))]
    fn new(
        py: Python<'_>,
        machine: &Machine,
        seed: Option<u64>,
        q: Option<&Bound<'_, PyAny>>,
        tension_n: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let design = &machine.machine;
        let q = q.map(|q| Numbers::from_python(q, "q")).transpose()?;
        let q = q.as_ref().map(|q| q.row("q", machine.joints())).transpose()?.unwrap_or(&design.start);
        let tension = tension_n.map(|tension| Numbers::from_python(tension, "tension_n")).transpose()?;
        let tension =
            tension.as_ref().map(|tension| tension.row("tension_n", machine.muscles())).transpose()?;
        let inner = py.detach(|| at_rest(design, seed, q, tension, &limits(design, tension.is_some())?))?;
        Ok(Self::of(inner))
    }

    /// All drives execute their commands for `interval_s` seconds, 1e-5 to 0.02; by default for a period of
    /// the machine.
    ///
    /// `command`: shape `(muscles,)`; NaN switches a drive off. `kind`: `"speed"` for the speed of the cable
    /// at the winch, m/s, positive toward the motor, `"tension"` for the tension at the drive's outlet, N,
    /// `"current"` for that of the motor, A.
    #[pyo3(signature = (command, interval_s=None, *, kind="speed"))]
    fn step(
        &mut self,
        py: Python<'_>,
        command: &Bound<'_, PyAny>,
        interval_s: Option<f64>,
        kind: &str,
    ) -> PyResult<()> {
        let command = Numbers::from_python(command, "command")?;
        let command = command.row("command", self.commands.len())?;
        let make = command_of(kind)?;
        self.commands.iter_mut().zip(command).for_each(|(to, number)| *to = make(*number));
        let Self { inner, commands } = self;
        let interval_s = interval_s.unwrap_or(inner.specimen().period);
        py.detach(|| inner.step(commands, interval_s).map(drop)).map_err(Failure::from)?;
        Ok(())
    }

    /// A twin that continues independently from the same state.
    fn copy(&self) -> Self {
        Self { inner: self.inner.clone(), commands: self.commands.clone() }
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.copy()
    }

    /// Time since the start, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.inner.truth().time
    }

    /// True pose, rad or m, shape `(joints,)`.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.inner.truth().q)
    }

    /// True velocities, per s, shape `(joints,)`.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.inner.truth().v)
    }

    /// True lengths from sheath to anchor, m, shape `(muscles,)`.
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.inner.truth().lengths)
    }

    /// True tensions at the drives, N, shape `(muscles,)`.
    #[getter]
    fn tension_in<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.truth().cables.iter().map(|cable| cable.tension_in).collect::<Vec<_>>())
    }

    /// True tensions at the anchors, N, shape `(muscles,)`.
    #[getter]
    fn tension_out<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.truth().cables.iter().map(|cable| cable.tension_out).collect::<Vec<_>>())
    }

    /// True stretch of the cables, m, shape `(muscles,)`.
    #[getter]
    fn stretch<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.truth().cables.iter().map(|cable| cable.stretch).collect::<Vec<_>>())
    }

    /// Measured positions of the cables by the motors' encoders, m, positive toward the motor, shape
    /// `(muscles,)`.
    #[getter]
    fn measured_motor<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.reading().motor)
    }

    /// Measured tensions at the drives' outlets, N, shape `(muscles,)`.
    #[getter]
    fn measured_tension<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.reading().tension)
    }

    /// Measured pose by the joints' encoders, rad or m, NaN without one, shape `(joints,)`.
    #[getter]
    fn measured_joint<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, &self.inner.reading().joint)
    }
}
