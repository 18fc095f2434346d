//! Identified models: their fit, their scores, their predictions.

use crate::compensator::Compensator;
use crate::failure::Failure;
use crate::logs::{ColumnKeywords, Logs};
use crate::long_call::{self, Progress};
use crate::predictor::{Columns, Predictor};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::compensator::CompensatorSettings;
use sinew_identify::adapt::adapt;
use sinew_identify::compensate::input_named;
use sinew_identify::evaluate::{evaluate, predict};
use sinew_identify::identify::{Identification, Keep, Options, Preference, identify as identify_logs};
use sinew_identify::log::{Dataset, RequestedRoles};
use sinew_identify::report::IdentificationReport;
use std::sync::Arc;

/// A model of one transmission, with the report of its identification where it was identified in this
/// process.
#[pyclass(frozen, module = "sinew._sinew")]
pub(crate) struct Model {
    model: Arc<sinew::predictor::Model>,
    report: Option<Arc<IdentificationReport>>,
}

impl From<Identification> for Model {
    fn from(identified: Identification) -> Self {
        Self { model: Arc::new(identified.model), report: Some(Arc::new(identified.report)) }
    }
}

/// Identifies a model from logs.
#[pyfunction]
#[pyo3(signature = (logs, roles, columns, skip_s, models, keep, loss_percent, seed, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "positional here, keywords in the Python face")]
pub(crate) fn identify(
    py: Python<'_>,
    logs: Logs,
    roles: Roles,
    columns: ColumnKeywords,
    skip_s: f64,
    models: Vec<String>,
    keep: Option<Vec<String>>,
    loss_percent: Option<f64>,
    seed: u64,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Model> {
    let keep = match keep {
        None => Keep::All,
        Some(names) if names.is_empty() => Keep::Judged,
        Some(names) => Keep::Logs(names),
    };
    let prefer = not_negative("loss_percent", loss_percent)?
        .map_or(Preference::Accurate, |loss_percent| Preference::Simple { loss_percent });
    long_call::run(py, progress, threads, move |progress| {
        progress.tell("reading logs", 0.0);
        let data = logs.read(&roles.into(), skip_s, columns.into())?;
        let options = Options { seed, models, keep, prefer };
        Ok(identify_logs(&data, &options, &|stage, done| progress.tell(stage, done))?.into())
    })
}

/// Columns by role.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Roles {
    far: Option<String>,
    effort: Vec<String>,
    motion: Vec<String>,
    anchor: Option<String>,
    given: Vec<String>,
    time: Option<String>,
    trial: Option<String>,
    group: Option<String>,
    ignore: Vec<String>,
}

impl From<Roles> for RequestedRoles {
    fn from(roles: Roles) -> Self {
        let Roles { far, effort, motion, anchor, given, time, trial, group, ignore } = roles;
        Self { far, effort, motion, anchor, given, time, trial, group, ignore }
    }
}

#[pymethods]
impl Model {
    /// Reads the text of a model file.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let model = py.detach(|| sinew::predictor::Model::from_json(text)).map_err(Failure::from)?;
        Ok(Self { model: Arc::new(model), report: None })
    }

    /// The text of a model file.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        Ok(py.detach(|| self.model.to_json()).map_err(Failure::from)?)
    }

    /// The column that it predicts.
    #[getter]
    fn far(&self) -> &str {
        &self.model.far
    }

    /// Names and roles of the columns that it reads.
    #[getter]
    fn inputs(&self) -> Vec<(&str, &'static str)> {
        let role = |role| match role {
            sinew::predictor::Role::Effort => "effort",
            sinew::predictor::Role::Motion => "motion",
            sinew::predictor::Role::Anchor => "anchor",
            sinew::predictor::Role::Given => "given",
        };
        self.model.inputs.iter().map(|input| (input.column.as_str(), role(input.role))).collect()
    }

    /// Origin of the model as JSON.
    fn provenance_json(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.model.provenance).map_err(Failure::from)?)
    }

    /// The report of the identification without its traces, as JSON.
    fn report_json(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(report) = &self.report else { return Ok(None) };
        let text = py.detach(|| {
            let report = IdentificationReport { traces: Vec::new(), ..IdentificationReport::clone(report) };
            serde_json::to_string(&report)
        });
        Ok(Some(text.map_err(Failure::from)?))
    }

    /// The page of the identification, one HTML file.
    fn report_html(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(report) = &self.report else { return Ok(None) };
        Ok(Some(py.detach(|| sinew_report::render(report)).map_err(Failure::from)?))
    }

    /// Scores on logs that hold the far end, as JSON.
    #[pyo3(signature = (logs, columns, skip_s, anchor_reading_s))]
    fn evaluate(
        &self,
        py: Python<'_>,
        logs: Logs,
        columns: ColumnKeywords,
        skip_s: f64,
        anchor_reading_s: Option<f64>,
    ) -> PyResult<String> {
        let reading = not_negative("anchor_reading_s", anchor_reading_s)?;
        let model = self.model.clone();
        long_call::run(py, None, None, move |_| {
            let data = logs.read_for(&model, skip_s, true, columns.into())?;
            Ok(serde_json::to_string(&evaluate(&model, &data, reading)?)?)
        })
    }

    /// Predictions of every sample of logs, as columns.
    #[pyo3(signature = (logs, columns, anchor_reading_s))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        logs: Logs,
        columns: ColumnKeywords,
        anchor_reading_s: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let reading = not_negative("anchor_reading_s", anchor_reading_s)?;
        let options = columns.into();
        let model = self.model.clone();
        let (data, columns) = long_call::run(py, None, None, move |_| {
            let data = logs.read_for(&model, 0.0, false, options)?;
            let mut columns = Columns::default();
            for prediction in predict(&model, &data, reading)?.rows.iter().flatten() {
                columns.push(prediction);
            }
            Ok((data, columns))
        })?;
        let result = places(py, &data)?;
        let mut measured = Vec::new();
        for sequence in &data.sequences {
            measured.extend_from_slice(&sequence.far);
            measured.resize(measured.len() + sequence.time_s.len() - sequence.far.len(), f64::NAN);
        }
        result.set_item("measured", PyArray1::from_vec(py, measured))?;
        columns.write(py, &result)?;
        Ok(result)
    }

    /// Adapts the model to another specimen.
    #[allow(clippy::too_many_arguments, reason = "the keywords of Python's function")]
    #[pyo3(signature = (logs, columns, skip_s, seed, threads, progress))]
    fn adapt(
        &self,
        py: Python<'_>,
        logs: Logs,
        columns: ColumnKeywords,
        skip_s: f64,
        seed: u64,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let model = self.model.clone();
        long_call::run(py, progress, threads, move |progress: &Progress| {
            let data = logs.read_for(&model, skip_s, true, columns.into())?;
            let options = Options { seed, ..Options::default() };
            Ok(adapt(&model, &data, &options, &|stage, done| progress.tell(stage, done))?.into())
        })
    }

    /// A compensator before its first sample: the inverse of the model.
    #[pyo3(signature = (near, min, max, rate, tolerance))]
    fn compensator(
        &self,
        near: Option<&str>,
        min: Option<f64>,
        max: Option<f64>,
        rate: Option<f64>,
        tolerance: Option<f64>,
    ) -> PyResult<Compensator> {
        let named = |column: &str| {
            input_named(&self.model, column).ok_or_else(|| {
                Failure::refused(format!("near: expected an input of the model, got {column}"))
            })
        };
        let near = near.map(named).transpose()?;
        Compensator::new(&self.model, &CompensatorSettings { near, min, max, rate, tolerance })
    }

    /// A predictor before its first sample.
    fn predictor(&self) -> PyResult<Predictor> {
        Predictor::new(&self.model)
    }
}

/// A keyword that is a finite number of at least 0, or absent.
fn not_negative(name: &str, value: Option<f64>) -> Result<Option<f64>, Failure> {
    match value {
        Some(value) if !(value >= 0.0 && value.is_finite()) => {
            Err(Failure::refused(format!("{name}: expected a finite number >= 0, got {value}")))
        }
        sound => Ok(sound),
    }
}

/// Names of logs and trials with their indices, and the time, for every sample of a dataset.
fn places<'py>(py: Python<'py>, data: &Dataset) -> PyResult<Bound<'py, PyDict>> {
    let (mut log, mut trial, mut time) = (Vec::<i64>::new(), Vec::<i64>::new(), Vec::new());
    for (sequence, index) in data.sequences.iter().zip(0_i64..) {
        log.resize(log.len() + sequence.time_s.len(), i64::try_from(sequence.log).unwrap_or(-1));
        trial.resize(trial.len() + sequence.time_s.len(), index);
        time.extend_from_slice(&sequence.time_s);
    }
    let result = PyDict::new(py);
    result.set_item("log_names", data.logs.iter().map(|log| log.name.as_str()).collect::<Vec<_>>())?;
    result.set_item("trial_names", data.sequences.iter().map(|s| s.trial.as_str()).collect::<Vec<_>>())?;
    result.set_item("log_index", PyArray1::from_vec(py, log))?;
    result.set_item("trial_index", PyArray1::from_vec(py, trial))?;
    result.set_item("time_s", PyArray1::from_vec(py, time))?;
    Ok(result)
}

/// Simulated logs of a bench: names and contents of CSV files; the last one is for testing.
#[pyfunction]
pub(crate) fn demo_logs(py: Python<'_>, seed: u64) -> PyResult<Vec<(String, String)>> {
    long_call::run(py, None, None, move |_| Ok(sinew_lab::simulated::demo_logs(seed)))
}
