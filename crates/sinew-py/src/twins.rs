//! Many simulated machines of one design, stepped together.

use crate::array::{Rows, array, wrong_shape};
use crate::failure::Failure;
use crate::long_call::at;
use crate::machine::Machine;
use crate::twin::{Twin, at_rest, command_of, limits};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use sinew::drive::DriveCommand;
use sinew::twin::arm::{ArmTruth, ArmTwin};
use sinew::twin::cable::CableReading;
use std::sync::Arc;

/// One row for every world, as it is returned.
type Table<'py> = PyResult<Bound<'py, PyArrayDyn<f64>>>;

/// Many simulated machines of one design, stepped together: each has the bits of a `Twin` of its seed.
///
/// `seeds`: one for every world, or None for the machine as designed. `q` and `tension_n` as of `Twin`, of
/// the shapes `(worlds, joints)` and `(worlds, muscles)`, or one row for all. `threads`: the calling one
/// among them. All arrays have one row for every world. Everything is simulated.
#[pyclass(module = "sinew")]
#[derive(Clone)]
pub(crate) struct TwinBatch {
    batch: sinew_gym::TwinBatch,
    machine: Arc<sinew::machine::Machine>,
    /// Of the tensions in equilibrium; empty where none are.
    limits: Vec<[f64; 2]>,
    starts: Vec<Start>,
    commands: Vec<DriveCommand>,
}

/// How a world begins.
#[derive(Clone)]
struct Start {
    seed: Option<u64>,
    q: Vec<f64>,
    tension: Option<Vec<f64>>,
}

/// Rows of every world, or one for all.
fn rows<'py>(
    value: Option<&Bound<'py, PyAny>>,
    name: &'static str,
    [worlds, width]: [usize; 2],
) -> PyResult<Option<Rows<'py>>> {
    let Some(value) = value else { return Ok(None) };
    let rows = Rows::from_python(value, name, width)?;
    if !rows.lead().is_empty() && rows.lead() != [worlds] {
        let shape: Vec<usize> = rows.lead().iter().copied().chain([width]).collect();
        return Err(wrong_shape(name, &format!("({worlds}, {width}) or ({width},)"), &shape).into());
    }
    Ok(Some(rows))
}

impl TwinBatch {
    /// Changes how worlds begin by what is given.
    fn changed(
        mut starts: Vec<Start>,
        (q, tension): (Option<&Bound<'_, PyAny>>, Option<&Bound<'_, PyAny>>),
        [joints, muscles]: [usize; 2],
    ) -> PyResult<Vec<Start>> {
        let q = rows(q, "q", [starts.len(), joints])?;
        let tension = rows(tension, "tension_n", [starts.len(), muscles])?;
        let (q, tension) = (q.as_ref().map(Rows::view), tension.as_ref().map(Rows::view));
        let (q, tension) = (q.transpose()?, tension.transpose()?);
        for (k, start) in starts.iter_mut().enumerate() {
            start.q = q.map_or_else(|| std::mem::take(&mut start.q), |q| q.row(k).to_vec());
            start.tension = tension.map(|tension| tension.row(k).to_vec()).or_else(|| start.tension.take());
        }
        Ok(starts)
    }

    /// Numbers of every world.
    fn table<'py>(&self, py: Python<'py>, row: impl Fn(&ArmTwin, &mut Vec<f64>)) -> Table<'py> {
        let (twins, mut numbers) = (self.batch.twins(), Vec::new());
        twins.iter().for_each(|twin| row(twin, &mut numbers));
        let width = numbers.len() / twins.len();
        array(py, numbers, &[twins.len()], &[width])
    }

    /// Numbers of the truth of every world.
    fn truth<'py>(&self, py: Python<'py>, row: impl Fn(ArmTruth<'_>) -> &[f64]) -> Table<'py> {
        self.table(py, |twin, all| all.extend_from_slice(row(twin.truth())))
    }

    /// A number of every cable.
    fn cables<'py>(&self, py: Python<'py>, of: impl Fn(&CableReading) -> f64) -> Table<'py> {
        self.table(py, |twin, all| all.extend(twin.truth().cables.iter().map(&of)))
    }
}

#[pymethods]
impl TwinBatch {
    #[new]
    #[pyo3(signature = (machine, seeds, *, q=None, tension_n=None, threads=1))]
    #[expect(clippy::needless_pass_by_value, reason = "lists are extracted, not borrowed")]
    fn new(
        py: Python<'_>,
        machine: &Machine,
        seeds: Vec<Option<u64>>,
        q: Option<&Bound<'_, PyAny>>,
        tension_n: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<Self> {
        let (machine, shape) = (machine.machine.clone(), [machine.joints(), machine.muscles()]);
        let start = |seed: &Option<u64>| Start { seed: *seed, q: machine.start.clone(), tension: None };
        let starts = Self::changed(seeds.iter().map(start).collect(), (q, tension_n), shape)?;
        let (worlds, given) = (starts.len(), tension_n.is_some());
        let (batch, limits) = py.detach(|| {
            let limits = limits(&machine, given)?;
            let made = |k| begun(&machine, (&starts, k), &limits);
            Ok::<_, Failure>((sinew_gym::TwinBatch::new(worlds, threads, made)?, limits))
        })?;
        Ok(Self { batch, machine, limits, starts, commands: vec![DriveCommand::Off; worlds * shape[1]] })
    }

    /// Worlds begin anew where `mask` is true, all without one: as they began last, but for what is given.
    ///
    /// `mask`: shape `(worlds,)`. `seeds`, `q`, `tension_n` as at the beginning; rows of other worlds are not
    /// used.
    #[pyo3(signature = (mask=None, *, seeds=None, q=None, tension_n=None))]
    fn reset(
        &mut self,
        py: Python<'_>,
        mask: Option<Vec<bool>>,
        seeds: Option<Vec<Option<u64>>>,
        q: Option<&Bound<'_, PyAny>>,
        tension_n: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let worlds = self.starts.len();
        let lengths = [("mask", mask.as_ref().map(Vec::len)), ("seeds", seeds.as_ref().map(Vec::len))];
        for (name, length) in lengths {
            if let Some(length) = length.filter(|length| *length != worlds) {
                return Err(wrong_shape(name, &format!("({worlds},)"), &[length]).into());
            }
        }
        let mask = mask.unwrap_or_else(|| vec![true; worlds]);
        let shape = [self.machine.start.len(), self.machine.muscles.len()];
        let mut starts = Self::changed(self.starts.clone(), (q, tension_n), shape)?;
        if let Some(seeds) = seeds {
            starts.iter_mut().zip(seeds).for_each(|(start, seed)| start.seed = seed);
        }
        let Self { batch, machine, limits, .. } = self;
        py.detach(|| batch.reset(&mask, |k| begun(machine, (&starts, k), limits)))?;
        let chosen = self.starts.iter_mut().zip(starts).zip(mask).filter(|(_, chosen)| *chosen);
        chosen.for_each(|((start, new), _)| *start = new);
        Ok(())
    }

    /// All drives of all worlds execute their commands for `interval_s` seconds, 1e-5 to 0.02; by default for
    /// a period of the machine.
    ///
    /// `command`: shape `(worlds, muscles)`, or one row for all; NaN switches a drive off. `kind` as of
    /// `Twin.step`. A world that cannot go on stays as it is until it is reset; `failed` names it.
    #[pyo3(signature = (command, interval_s=None, *, kind="speed"))]
    fn step(
        &mut self,
        py: Python<'_>,
        command: &Bound<'_, PyAny>,
        interval_s: Option<f64>,
        kind: &str,
    ) -> PyResult<()> {
        let make = command_of(kind)?;
        let muscles = self.machine.muscles.len();
        let rows = rows(Some(command), "command", [self.starts.len(), muscles])?;
        if let Some(view) = rows.as_ref().map(Rows::view).transpose()? {
            for (k, commands) in self.commands.chunks_exact_mut(muscles).enumerate() {
                commands.iter_mut().zip(view.row(k)).for_each(|(to, number)| *to = make(*number));
            }
        }
        let Self { batch, commands, machine, .. } = self;
        let interval_s = interval_s.unwrap_or(machine.period);
        Ok(py.detach(|| batch.step(commands, interval_s)).map_err(Failure::from)?)
    }

    /// A batch that continues independently from the same state, with the same threads.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    /// A twin that continues independently from the state of one world.
    fn twin(&self, world: usize) -> PyResult<Twin> {
        let twins = self.batch.twins();
        let refused = || Failure::refused(format!("world must be below {}, but is {world}", twins.len()));
        Ok(Twin::of(twins.get(world).ok_or_else(refused)?.clone()))
    }

    /// Number of worlds.
    fn __len__(&self) -> usize {
        self.starts.len()
    }

    /// Whether a world cannot go on until it is reset, shape `(worlds,)`.
    #[getter]
    fn failed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_iter(py, self.batch.failures().iter().map(Option::is_some))
    }

    /// Why worlds cannot go on, None where they can.
    #[getter]
    fn failures(&self) -> Vec<Option<String>> {
        self.batch.failures().iter().map(|failure| failure.map(|error| error.to_string())).collect()
    }

    /// Time since the start, s, shape `(worlds,)`.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.batch.twins().iter().map(|twin| twin.truth().time))
    }

    /// True poses, rad or m, shape `(worlds, joints)`.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.truth(py, |truth| truth.q)
    }

    /// True velocities, per s, shape `(worlds, joints)`.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.truth(py, |truth| truth.v)
    }

    /// True lengths from sheath to anchor, m, shape `(worlds, muscles)`.
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.truth(py, |truth| truth.lengths)
    }

    /// True tensions at the drives, N, shape `(worlds, muscles)`.
    #[getter]
    fn tension_in<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.cables(py, |cable| cable.tension_in)
    }

    /// True tensions at the anchors, N, shape `(worlds, muscles)`.
    #[getter]
    fn tension_out<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.cables(py, |cable| cable.tension_out)
    }

    /// True stretch of the cables, m, shape `(worlds, muscles)`.
    #[getter]
    fn stretch<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.cables(py, |cable| cable.stretch)
    }

    /// Measured positions of the cables by the motors' encoders, m, positive toward the motor, shape
    /// `(worlds, muscles)`.
    #[getter]
    fn measured_motor<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.table(py, |twin, all| all.extend_from_slice(&twin.reading().motor))
    }

    /// Measured tensions at the drives' outlets, N, shape `(worlds, muscles)`.
    #[getter]
    fn measured_tension<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.table(py, |twin, all| all.extend_from_slice(&twin.reading().tension))
    }

    /// Measured poses by the joints' encoders, rad or m, NaN without one, shape `(worlds, joints)`.
    #[getter]
    fn measured_joint<'py>(&self, py: Python<'py>) -> Table<'py> {
        self.table(py, |twin, all| all.extend_from_slice(&twin.reading().joint))
    }
}

/// A world at its beginning.
fn begun(
    machine: &sinew::machine::Machine,
    (starts, k): (&[Start], usize),
    limits: &[[f64; 2]],
) -> Result<ArmTwin, Failure> {
    let Start { seed, q, tension } = &starts[k];
    at_rest(machine, *seed, q, tension.as_deref(), limits).map_err(|error| at(starts.len(), k, &error))
}
