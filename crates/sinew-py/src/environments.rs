//! Environments for reinforcement learning, many at once; they write into arrays of the caller.

use crate::array::array;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::track::Trajectory;
use crate::worlds;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadwriteArray};
use pyo3::prelude::*;
use sinew::twin::cable::Resolution;
use sinew_gym::{
    Actuation, EnvironmentBatch, EnvironmentDesign, Outcomes, Randomisation, ResetMode, Settings, Task,
};
use std::sync::Arc;

/// Many simulated machines under one task; see `sinew.gym`.
#[pyclass(module = "sinew._sinew")]
pub(crate) struct Environments {
    batch: EnvironmentBatch,
    design: Arc<EnvironmentDesign>,
}

/// Task, settings and randomisation as the Python face gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Conditions {
    task: String,
    trajectory: Option<Py<Trajectory>>,
    push: f64,
    actuation: String,
    interval_ms: Option<u32>,
    steps: u32,
    cells: usize,
    substeps: usize,
    spread: f64,
    effort: f64,
    tolerances: bool,
    friction: [f64; 2],
    bend: [f64; 2],
    mass: [f64; 2],
    delay_ms: [f64; 2],
}

impl Conditions {
    fn task(&self) -> Result<Task, Failure> {
        match (self.task.as_str(), &self.trajectory) {
            ("reach", _) => Ok(Task::Reach),
            ("hold", _) => Ok(Task::Hold { push: self.push }),
            ("track", Some(trajectory)) => Ok(Task::Track(trajectory.get().inner.clone())),
            ("track", None) => Err(Failure::refused("the task \"track\" needs a trajectory")),
            (other, _) => Err(Failure::refused(format!(
                "task must be \"reach\", \"track\" or \"hold\", but is {other:?}"
            ))),
        }
    }

    fn settings(&self, period: f64) -> Result<Settings, Failure> {
        let actuation = match self.actuation.as_str() {
            "speed" => Actuation::Speed,
            "tension" => Actuation::Tension,
            "torque" => Actuation::Torque,
            other => {
                let expected = "actuation must be \"speed\", \"tension\" or \"torque\"";
                return Err(Failure::refused(format!("{expected}, but is {other:?}")));
            }
        };
        let resolution = Resolution { cells: self.cells, substeps: self.substeps };
        let Self { steps, spread, effort, .. } = *self;
        let interval_ms = self.interval_ms.unwrap_or_else(|| Settings::interval_for(period));
        Ok(Settings { actuation, interval_ms, steps, resolution, spread, effort })
    }

    fn randomisation(&self) -> Randomisation {
        let Self { tolerances, friction, bend, mass, delay_ms, .. } = *self;
        Randomisation { tolerances, friction, bend, mass, delay_ms }
    }
}

/// An array of the caller that is written in place.
type Writable<'a, 'py, T> = &'a Bound<'py, PyArrayDyn<T>>;

fn writable<'py, T: Element>(
    array: Writable<'_, 'py, T>,
    name: &str,
) -> PyResult<PyReadwriteArray<'py, T, numpy::IxDyn>> {
    let refused = || Failure::refused(format!("{name} must be writable and not be in use by another call"));
    Ok(array.try_readwrite().map_err(|_| refused())?)
}

fn contiguous<'a, T: Element>(
    array: &'a mut PyReadwriteArray<'_, T, numpy::IxDyn>,
    name: &str,
) -> PyResult<&'a mut [T]> {
    let refused = || Failure::refused(format!("{name} must be contiguous in C order"));
    Ok(array.as_slice_mut().map_err(|_| refused())?)
}

#[pymethods]
impl Environments {
    #[new]
    #[expect(clippy::needless_pass_by_value, reason = "lists are extracted, not borrowed")]
    fn new(
        py: Python<'_>,
        machine: &Machine,
        conditions: Conditions,
        seeds: Vec<u64>,
        reset_mode: &str,
        threads: usize,
    ) -> PyResult<Self> {
        let mode = match reset_mode {
            "next_step" => ResetMode::NextStep,
            "same_step" => ResetMode::SameStep,
            "disabled" => ResetMode::Disabled,
            other => {
                let expected = "reset_mode must be \"next_step\", \"same_step\" or \"disabled\"";
                return Err(Failure::refused(format!("{expected}, but is {other:?}")).into());
            }
        };
        let machine = machine.machine.clone();
        let (task, settings) = (conditions.task()?, conditions.settings(machine.period)?);
        let randomisation = conditions.randomisation();
        let made = py.detach(|| {
            let design = Arc::new(EnvironmentDesign::new(&machine, task, settings, randomisation)?);
            Ok::<_, Failure>((EnvironmentBatch::new(&design, &seeds, mode, threads)?, design))
        });
        let (batch, design) = made?;
        Ok(Self { batch, design })
    }

    /// Begins episodes where `mask` is true, everywhere without one; with seeds, the first episode of each.
    #[expect(clippy::needless_pass_by_value, reason = "lists are extracted, not borrowed")]
    fn reset(
        &mut self,
        py: Python<'_>,
        seeds: Option<Vec<u64>>,
        mask: Option<Vec<bool>>,
        observations: Writable<'_, '_, f32>,
        errors: Writable<'_, '_, f64>,
    ) -> PyResult<()> {
        let (mut observations, mut errors) =
            (writable(observations, "observations")?, writable(errors, "errors")?);
        let observations = contiguous(&mut observations, "observations")?;
        let errors = contiguous(&mut errors, "errors")?;
        let batch = &mut self.batch;
        py.detach(|| batch.reset(seeds.as_deref(), mask.as_deref(), observations, errors))
            .map_err(|error| Failure::from(error).into())
    }

    /// One action for every environment; everything is written into the arrays.
    #[expect(clippy::too_many_arguments, reason = "every array has a name of its own")]
    fn step(
        &mut self,
        py: Python<'_>,
        actions: Writable<'_, '_, f32>,
        observations: Writable<'_, '_, f32>,
        rewards: Writable<'_, '_, f64>,
        terminated: Writable<'_, '_, bool>,
        truncated: Writable<'_, '_, bool>,
        errors: Writable<'_, '_, f64>,
        last_observations: Writable<'_, '_, f32>,
        last_errors: Writable<'_, '_, f64>,
    ) -> PyResult<()> {
        let actions = actions.try_readonly().map_err(|e| Failure::Internal(e.to_string()))?;
        let actions = actions.as_slice().map_err(|e| Failure::refused(format!("actions: {e}")))?;
        let mut arrays = (
            writable(observations, "observations")?,
            writable(last_observations, "last_observations")?,
            writable(rewards, "rewards")?,
            writable(errors, "errors")?,
            writable(terminated, "terminated")?,
            writable(truncated, "truncated")?,
            writable(last_errors, "last_errors")?,
        );
        let mut out = Outcomes {
            observations: contiguous(&mut arrays.0, "observations")?,
            last_observations: contiguous(&mut arrays.1, "last_observations")?,
            rewards: contiguous(&mut arrays.2, "rewards")?,
            errors: contiguous(&mut arrays.3, "errors")?,
            terminated: contiguous(&mut arrays.4, "terminated")?,
            truncated: contiguous(&mut arrays.5, "truncated")?,
            last_errors: contiguous(&mut arrays.6, "last_errors")?,
        };
        let batch = &mut self.batch;
        py.detach(|| batch.step(actions, &mut out)).map_err(|error| Failure::from(error).into())
    }

    /// Milliseconds that an action holds.
    #[getter]
    fn interval_ms(&self) -> u32 {
        self.design.settings().interval_ms
    }

    /// Entries of an action.
    #[getter]
    fn actions(&self) -> usize {
        self.design.actions()
    }

    /// Entries of an observation.
    #[getter]
    fn observations(&self) -> usize {
        self.design.observations()
    }

    /// Smallest and largest value of every entry of an observation.
    #[getter]
    fn observation_bounds(&self) -> (Vec<f32>, Vec<f32>) {
        self.design.observation_bounds().iter().map(|[low, high]| (*low, *high)).unzip()
    }

    /// Name, unit, first entry and number of entries of every part of an observation.
    #[getter]
    fn observation_parts(&self) -> Vec<(&'static str, &'static str, usize, usize)> {
        let parts = self.design.observation_parts().iter();
        parts.map(|part| (part.name, part.unit, part.start, part.width)).collect()
    }

    /// Commands of the actions -1 and 1, m/s, N or A of the motor, one pair for every muscle.
    #[getter]
    fn command_bounds(&self) -> Vec<[f64; 2]> {
        self.design.command_bounds().to_vec()
    }

    /// Error at which the reward is a half, m or 1.
    #[getter]
    fn half_error(&self) -> f64 {
        self.design.half_error()
    }

    /// Cells of every cable, and substeps of a millisecond.
    #[getter]
    fn resolution(&self) -> (usize, usize) {
        let Resolution { cells, substeps } = self.design.resolution();
        (cells, substeps)
    }

    /// What all environments share, as JSON, for another simulator.
    fn design(&self) -> PyResult<String> {
        Ok(worlds::design(&self.design).map_err(Failure::from)?.to_string())
    }

    /// The episode that one environment is in, as JSON: its specimen, its noise, its pushes, its targets.
    fn episode(&self, index: usize) -> PyResult<String> {
        let environments = self.batch.environments();
        let one = environments.get(index).ok_or_else(|| {
            Failure::refused(format!("index must be below {}, but is {index}", environments.len()))
        })?;
        Ok(worlds::episode(one).map_err(Failure::from)?.to_string())
    }

    /// True poses, rad or m, shape `(environments, joints)`.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let environments = self.batch.environments();
        let poses: Vec<f64> = environments.iter().flat_map(|one| one.twin().truth().q.to_vec()).collect();
        let width = poses.len() / environments.len();
        array(py, poses, &[environments.len()], &[width])
    }
}
