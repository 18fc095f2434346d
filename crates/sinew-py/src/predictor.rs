//! Prediction of the far end, sample by sample.

use crate::array::{Numbers, wrong_shape};
use crate::failure::Failure;
use crate::long_call;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::predictor::{Flags, Model, Sample};

/// Prediction of the far end at one sample.
#[pyclass(frozen, module = "sinew")]
#[derive(Clone)]
pub(crate) struct Prediction(sinew::predictor::Prediction);

#[pymethods]
impl Prediction {
    /// The far end, in the unit of the training logs.
    #[getter]
    fn mean(&self) -> f64 {
        self.0.mean
    }

    /// Standard deviation in the same unit; `mean ± half_width` is the 95 % band.
    #[getter]
    fn standard_deviation(&self) -> f64 {
        self.0.standard_deviation
    }

    /// Half width of the 95 % band, in the same unit.
    #[getter]
    fn half_width(&self) -> f64 {
        self.0.half_width()
    }

    /// Gate on the learned correction, 0 to 1.
    #[getter]
    fn gate(&self) -> f64 {
        self.0.gate
    }

    /// Whether the state in the dead band depends on its start.
    #[getter]
    fn state_unknown(&self) -> bool {
        self.0.flags.state_unknown
    }

    /// Whether an input lies outside the range of the training logs.
    #[getter]
    fn out_of_range(&self) -> bool {
        self.0.flags.out_of_range
    }

    /// Whether an input was missing or jumped, and was replaced by its last value.
    #[getter]
    fn input_held(&self) -> bool {
        self.0.flags.input_held
    }

    /// Whether all states were reset at this sample.
    #[getter]
    fn reset(&self) -> bool {
        self.0.flags.reset
    }

    /// Whether the loops of near effort over near motion are not those of the specimen in training.
    #[getter]
    fn other_specimen(&self) -> bool {
        self.0.flags.other_specimen
    }

    /// Whether the time stamp equals that of the sample before.
    #[getter]
    fn repeated(&self) -> bool {
        self.0.flags.repeated
    }

    fn __float__(&self) -> f64 {
        self.0.mean
    }

    fn __repr__(&self) -> String {
        let names = names(self.0.flags).join(", ");
        let flags = if names.is_empty() { names } else { format!("; {names}") };
        format!("Prediction({:.6} ± {:.6}{flags})", self.0.mean, self.0.half_width())
    }
}

fn names(flags: Flags) -> Vec<&'static str> {
    let all = [
        (flags.state_unknown, "state_unknown"),
        (flags.out_of_range, "out_of_range"),
        (flags.input_held, "input_held"),
        (flags.reset, "reset"),
        (flags.repeated, "repeated"),
        (flags.other_specimen, "other_specimen"),
    ];
    all.iter().filter(|(set, _)| *set).map(|(_, name)| *name).collect()
}

/// Predictions as columns.
#[derive(Default)]
pub(crate) struct Columns {
    mean: Vec<f64>,
    standard_deviation: Vec<f64>,
    half_width: Vec<f64>,
    gate: Vec<f64>,
    flags: Vec<Flags>,
}

impl Columns {
    pub(crate) fn push(&mut self, prediction: &sinew::predictor::Prediction) {
        self.mean.push(prediction.mean);
        self.standard_deviation.push(prediction.standard_deviation);
        self.half_width.push(prediction.half_width());
        self.gate.push(prediction.gate);
        self.flags.push(prediction.flags);
    }

    pub(crate) fn write(self, py: Python<'_>, result: &Bound<'_, PyDict>) -> PyResult<()> {
        let flag = |of: fn(&Flags) -> bool| PyArray1::from_vec(py, self.flags.iter().map(of).collect());
        result.set_item("state_unknown", flag(|flags| flags.state_unknown))?;
        result.set_item("out_of_range", flag(|flags| flags.out_of_range))?;
        result.set_item("input_held", flag(|flags| flags.input_held))?;
        result.set_item("reset", flag(|flags| flags.reset))?;
        result.set_item("other_specimen", flag(|flags| flags.other_specimen))?;
        result.set_item("mean", PyArray1::from_vec(py, self.mean))?;
        result.set_item("standard_deviation", PyArray1::from_vec(py, self.standard_deviation))?;
        result.set_item("half_width", PyArray1::from_vec(py, self.half_width))?;
        result.set_item("gate", PyArray1::from_vec(py, self.gate))
    }
}

/// Predicts the far end of one transmission from its near side, sample by sample and causally.
///
/// Made by `Model.predictor`. Missing (NaN) and implausible inputs are replaced by the last accepted value
/// and flagged.
#[pyclass(module = "sinew")]
pub(crate) struct Predictor {
    inner: sinew::predictor::Predictor,
}

impl Predictor {
    pub(crate) fn new(model: &Model) -> PyResult<Self> {
        Ok(Self { inner: sinew::predictor::Predictor::new(model.clone()).map_err(Failure::from)? })
    }
}

#[pymethods]
impl Predictor {
    /// Predicts the far end at one sample.
    ///
    /// `time_s`: time, s, any origin. `inputs`: one number per column of `Model.inputs`, in that order and in
    /// the units of the training logs, shape `(inputs,)`; NaN for missing.
    fn step(&mut self, time_s: f64, inputs: &Bound<'_, PyAny>) -> PyResult<Prediction> {
        let inputs = Numbers::from_python(inputs, "inputs")?;
        let inputs = inputs.row("inputs", self.inner.model().inputs.len())?;
        Ok(Prediction(self.inner.step(&Sample { time_s, inputs })))
    }

    /// Predicts the far end at many samples, one after the other.
    ///
    /// `time_s`: shape `(n,)`, s. `inputs`: shape `(n, inputs)`. Returns a dictionary of arrays of shape
    /// `(n,)`: `mean`, `standard_deviation`, `half_width`, `gate`, and the flags as booleans.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        time_s: &Bound<'py, PyAny>,
        inputs: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (time, inputs) =
            (Numbers::from_python(time_s, "time_s")?, Numbers::from_python(inputs, "inputs")?);
        let width = self.inner.model().inputs.len();
        let [count] = time.shape() else {
            return Err(wrong_shape("time_s", "(n,)", time.shape()).into());
        };
        let count = *count;
        if inputs.shape() != [count, width] {
            return Err(wrong_shape("inputs", &format!("({count}, {width})"), inputs.shape()).into());
        }
        let (time, rows) = (time.slice()?, inputs.slice()?);
        let mut columns = Columns::default();
        let predictor = &mut self.inner;
        long_call::for_each(py, count, |k| {
            let inputs = &rows[k * width..(k + 1) * width];
            columns.push(&predictor.step(&Sample { time_s: time[k], inputs }));
            Ok(())
        })?;
        let result = PyDict::new(py);
        columns.write(py, &result)?;
        Ok(result)
    }

    /// Takes a reading of the far end at the last sample, as a homing or a stop gives it.
    ///
    /// Later predictions are moved by its error, shrunken by what the folds of the identification say of
    /// offsets. Returns that offset; None, and nothing changes, before the first sample, for a number that is
    /// not finite, and where the folds say nothing.
    fn read_far_end(&mut self, far: f64) -> Option<f64> {
        self.inner.read_far_end(far)
    }

    /// Resets all states: the next sample starts a new sequence.
    fn reset(&mut self) {
        self.inner.reset();
    }
}
