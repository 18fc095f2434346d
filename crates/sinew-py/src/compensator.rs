//! The near-side command for a desired far end, sample by sample.

use crate::array::{Numbers, wrong_shape};
use crate::failure::Failure;
use crate::long_call;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::compensator::{Command, CommandFlags, CompensatorSettings};
use sinew::predictor::{Model, Sample};
use sinew::transmission::Sliding;

/// Command for the near side at one sample.
#[pyclass(frozen, module = "sinew")]
#[derive(Clone)]
pub(crate) struct NearCommand(Command);

#[pymethods]
impl NearCommand {
    /// The near side for which the far end is as desired, in the unit of the near column.
    #[getter]
    fn value(&self) -> f64 {
        self.0.value
    }

    /// The command at the lower end of the model's 95 % band, as far as it can be reached in this sample.
    #[getter]
    fn low(&self) -> f64 {
        self.0.low
    }

    /// The command at the upper end of the model's 95 % band, as far as it can be reached in this sample.
    #[getter]
    fn high(&self) -> f64 {
        self.0.high
    }

    /// The far end that the model predicts at this command.
    #[getter]
    fn mean(&self) -> f64 {
        self.0.mean
    }

    /// Standard deviation of that prediction.
    #[getter]
    fn standard_deviation(&self) -> f64 {
        self.0.standard_deviation
    }

    /// Gate on the learned correction, 0 to 1.
    #[getter]
    fn gate(&self) -> f64 {
        self.0.gate
    }

    /// Whether the model's far end at this command is not the desired one.
    #[getter]
    fn not_attainable(&self) -> bool {
        self.0.flags.not_attainable
    }

    /// Whether the command moves as fast as it may.
    #[getter]
    fn rate_limited(&self) -> bool {
        self.0.flags.rate_limited
    }

    /// Whether the command or another input lies outside the range of the training logs.
    #[getter]
    fn out_of_range(&self) -> bool {
        self.0.flags.out_of_range
    }

    /// Whether less than half of the learned correction counts.
    #[getter]
    fn correction_withdrawn(&self) -> bool {
        self.0.flags.correction_withdrawn
    }

    /// Whether the state in the dead band depends on its start.
    #[getter]
    fn state_unknown(&self) -> bool {
        self.0.flags.state_unknown
    }

    /// Whether an input or the desired far end was missing or jumped, and was replaced by its last value.
    #[getter]
    fn input_held(&self) -> bool {
        self.0.flags.input_held
    }

    /// Whether all states were reset at this sample.
    #[getter]
    fn reset(&self) -> bool {
        self.0.flags.reset
    }

    /// Whether the time stamp equals that of the sample before.
    #[getter]
    fn repeated(&self) -> bool {
        self.0.flags.repeated
    }

    fn __float__(&self) -> f64 {
        self.0.value
    }

    fn __repr__(&self) -> String {
        let set = self.0.flags.named().into_iter().filter(|(_, set)| *set).map(|(name, _)| name);
        let names = set.collect::<Vec<_>>().join(", ");
        let flags = if names.is_empty() { names } else { format!("; {names}") };
        format!("NearCommand({:.6}, {:.6} to {:.6}{flags})", self.0.value, self.0.low, self.0.high)
    }
}

/// The near-side command for a desired far end, sample by sample and causally: the inverse of a model.
///
/// Made by `Model.compensator`. A controller calls `observe` with what it measured and `command` for the time
/// by which its drive can be there; `step` and `run` work through what is recorded or planned.
#[pyclass(module = "sinew")]
pub(crate) struct Compensator {
    inner: sinew::compensator::Compensator,
}

impl Compensator {
    pub(crate) fn new(model: &Model, settings: &CompensatorSettings) -> PyResult<Self> {
        let inner = sinew::compensator::Compensator::new(model.clone(), settings);
        Ok(Self { inner: inner.map_err(|error| Failure::refused(error.to_string()))? })
    }

    fn inputs(&self) -> usize {
        self.inner.model().inputs.len()
    }
}

#[pymethods]
impl Compensator {
    /// The column that is commanded.
    #[getter]
    fn near(&self) -> &str {
        &self.inner.model().inputs[self.inner.near()].column
    }

    /// The command for one sample, after which the state follows the near column, or the command where that
    /// is NaN.
    ///
    /// `time_s`: time, s. `inputs`: shape `(inputs,)`, one number per column of `Model.inputs`, NaN for
    /// missing. `desired`: the far end, in the unit of the training logs.
    fn step(&mut self, time_s: f64, inputs: &Bound<'_, PyAny>, desired: f64) -> PyResult<NearCommand> {
        let inputs = Numbers::from_python(inputs, "inputs")?;
        let inputs = inputs.row("inputs", self.inputs())?;
        Ok(NearCommand(self.inner.step(&Sample { time_s, inputs }, desired)))
    }

    /// The command for the sample at `time_s`, which lies ahead; the model's state is left as it is.
    ///
    /// `inputs`: those that are expected then, shape `(inputs,)`; the near column is not read.
    fn command(&mut self, time_s: f64, inputs: &Bound<'_, PyAny>, desired: f64) -> PyResult<NearCommand> {
        let inputs = Numbers::from_python(inputs, "inputs")?;
        let inputs = inputs.row("inputs", self.inputs())?;
        Ok(NearCommand(self.inner.command(&Sample { time_s, inputs }, desired)))
    }

    /// Moves the model's state by a sample as it was measured; the far end that the model predicts.
    ///
    /// `inputs`: shape `(inputs,)`, NaN for missing.
    fn observe(&mut self, time_s: f64, inputs: &Bound<'_, PyAny>) -> PyResult<f64> {
        let inputs = Numbers::from_python(inputs, "inputs")?;
        let inputs = inputs.row("inputs", self.inputs())?;
        Ok(self.inner.observe(&Sample { time_s, inputs }).mean)
    }

    /// The commands for many samples, one `step` after the other.
    ///
    /// `time_s`, `desired`: shape `(n,)`. `inputs`: shape `(n, inputs)`. Returns a dictionary of arrays of
    /// shape `(n,)`: `value`, `low`, `high`, `mean`, `standard_deviation`, `gate`, and the flags as booleans.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        time_s: &Bound<'py, PyAny>,
        inputs: &Bound<'py, PyAny>,
        desired: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (time, rows) = (Numbers::from_python(time_s, "time_s")?, Numbers::from_python(inputs, "inputs")?);
        let desired = Numbers::from_python(desired, "desired")?;
        let width = self.inputs();
        let [count] = time.shape() else {
            return Err(wrong_shape("time_s", "(n,)", time.shape()).into());
        };
        let count = *count;
        if rows.shape() != [count, width] {
            return Err(wrong_shape("inputs", &format!("({count}, {width})"), rows.shape()).into());
        }
        if desired.shape() != [count] {
            return Err(wrong_shape("desired", &format!("({count},)"), desired.shape()).into());
        }
        let (time, rows, desired) = (time.slice()?, rows.slice()?, desired.slice()?);
        let mut commands: Vec<Command> = Vec::new();
        let compensator = &mut self.inner;
        long_call::for_each(py, count, |k| {
            let inputs = &rows[k * width..(k + 1) * width];
            commands.push(compensator.step(&Sample { time_s: time[k], inputs }, desired[k]));
            Ok(())
        })?;
        let result = PyDict::new(py);
        let number = |of: fn(&Command) -> f64| PyArray1::from_vec(py, commands.iter().map(of).collect());
        result.set_item("value", number(|command| command.value))?;
        result.set_item("low", number(|command| command.low))?;
        result.set_item("high", number(|command| command.high))?;
        result.set_item("mean", number(|command| command.mean))?;
        result.set_item("standard_deviation", number(|command| command.standard_deviation))?;
        result.set_item("gate", number(|command| command.gate))?;
        for (k, (name, _)) in CommandFlags::default().named().iter().enumerate() {
            let flag: Vec<bool> = commands.iter().map(|command| command.flags.named()[k].1).collect();
            result.set_item(*name, PyArray1::from_vec(py, flag))?;
        }
        Ok(result)
    }

    /// The direction of sliding by which the last command of a cable's motor went, +1 toward the motor, -1
    /// away from it; 0 for other models. Set it to that in which the cable will slide by the time its
    /// drive has crossed the dead band, where the motion is known, before every command; 0: the motion
    /// shows it.
    #[getter]
    fn get_sliding(&self) -> f64 {
        self.inner.sliding().map_or(0.0, Sliding::sign)
    }

    #[setter]
    fn set_sliding(&mut self, direction: f64) {
        self.inner.expect_sliding(Sliding::from_velocity(direction));
    }

    /// Resets all states: the next sample starts a new sequence.
    fn reset(&mut self) {
        self.inner.reset();
    }
}
