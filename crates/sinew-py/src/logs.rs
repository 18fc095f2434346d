//! Logs from files and from columns in memory.

use crate::array::Numbers;
use crate::failure::Failure;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sinew_identify::Error;
use sinew_identify::evaluate::{conditions_of, roles_of};
use sinew_identify::log::{
    ColumnOptions, Dataset, ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles, read_dataset,
    read_with_roles,
};
use std::fmt::Write;
use std::path::PathBuf;

/// Logs as Python gives them: paths, or names and contents of files where any of them is in memory.
#[derive(Debug, FromPyObject)]
pub(crate) enum Logs {
    Files(Vec<PathBuf>),
    Contents(Vec<(String, Vec<u8>)>),
}

impl Logs {
    /// Reads logs whose columns are found by request and by name.
    pub(crate) fn read(
        self,
        roles: &RequestedRoles,
        skip_s: f64,
        columns: ColumnOptions,
    ) -> Result<Dataset, Error> {
        self.read_by(skip_s, true, columns, |paths, o| match paths {
            None => read_dataset(roles, o),
            Some(contents) => read_bytes(contents, roles, o),
        })
    }

    /// Reads logs with the columns of a model.
    pub(crate) fn read_for(
        self,
        model: &sinew::predictor::Model,
        skip_s: f64,
        far_required: bool,
        columns: ColumnOptions,
    ) -> Result<Dataset, Error> {
        let roles = roles_of(model);
        self.read_by(skip_s, far_required, columns, |contents, o| {
            let options = ReadOptions { conditions: conditions_of(model), ..o.clone() };
            match contents {
                None => read_with_roles(&roles, &options),
                Some(contents) => read_bytes_with_roles(contents, &roles, &options),
            }
        })
    }

    fn read_by(
        self,
        skip_s: f64,
        far_required: bool,
        columns: ColumnOptions,
        read: impl FnOnce(Option<&[(&str, &[u8])]>, &ReadOptions) -> Result<Dataset, Error>,
    ) -> Result<Dataset, Error> {
        match self {
            Self::Files(paths) => {
                let options = ReadOptions { skip_s, far_required, paths, columns, ..ReadOptions::default() };
                read(None, &options)
            }
            Self::Contents(contents) => {
                let borrowed: Vec<(&str, &[u8])> =
                    contents.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
                let options = ReadOptions { skip_s, far_required, columns, ..ReadOptions::default() };
                read(Some(&borrowed), &options)
            }
        }
    }
}

/// What the logs do not say of their columns.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ColumnKeywords {
    rename: Vec<(String, String)>,
    units: Vec<(String, String)>,
    rate_hz: Option<f64>,
}

impl From<ColumnKeywords> for ColumnOptions {
    fn from(ColumnKeywords { rename, units, rate_hz }: ColumnKeywords) -> Self {
        Self { rename, units, rate_hz }
    }
}

/// One column in memory.
enum Column<'py> {
    Numbers(Numbers<'py>),
    Labels(Vec<String>),
}

/// A table of columns as the text of a log: every number to its last bit, NaN as an empty cell.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "a list is extracted, not borrowed")]
pub(crate) fn table_text<'py>(
    py: Python<'py>,
    columns: Vec<(String, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyBytes>> {
    let mut read = Vec::new();
    for (name, column) in &columns {
        check_name(name)?;
        read.push(match column.extract::<Vec<String>>() {
            Ok(labels) => Column::Labels(checked_labels(name, labels)?),
            Err(_) => Column::Numbers(Numbers::from_python(column, name)?),
        });
    }
    let mut slices = Vec::new();
    for (column, (name, _)) in read.iter().zip(&columns) {
        slices.push(match column {
            Column::Labels(labels) => Cells::Labels(labels),
            Column::Numbers(numbers) if numbers.shape().len() == 1 => Cells::Numbers(numbers.slice()?),
            Column::Numbers(numbers) => {
                let shape = numbers.shape();
                return Err(Failure::refused(format!(
                    "column `{name}` must have one axis, but has {}",
                    shape.len()
                ))
                .into());
            }
        });
    }
    let rows = slices.first().map_or(0, Cells::len);
    for (cells, (name, _)) in slices.iter().zip(&columns) {
        if cells.len() != rows {
            let message = format!(
                "column `{name}` must have {rows} rows as `{}`, but has {}",
                columns[0].0,
                cells.len()
            );
            return Err(Failure::refused(message).into());
        }
    }
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let text = py.detach(|| text(&names, &slices, rows));
    Ok(PyBytes::new(py, text.as_bytes()))
}

enum Cells<'a> {
    Numbers(&'a [f64]),
    Labels(&'a [String]),
}

impl Cells<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Labels(labels) => labels.len(),
        }
    }
}

fn text(names: &[&str], columns: &[Cells<'_>], rows: usize) -> String {
    let mut text = names.join("\t") + "\n";
    for row in 0..rows {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                text.push('\t');
            }
            // Writing into a string cannot fail.
            let _ = match column {
                Cells::Numbers(numbers) if numbers[row].is_nan() => Ok(()),
                Cells::Numbers(numbers) => write!(text, "{:?}", numbers[row]),
                Cells::Labels(labels) => write!(text, "{}", labels[row]),
            };
        }
        text.push('\n');
    }
    text
}

/// Refuses a name that a table as text cannot have.
fn check_name(name: &str) -> Result<(), Failure> {
    let plain =
        !name.trim().is_empty() && name.trim() == name && !name.contains(['\t', '\n', '\r', '"', '\0']);
    if plain && !name.starts_with(['#', '%']) && !name.starts_with("//") && name.parse::<f64>().is_err() {
        return Ok(());
    }
    Err(Failure::refused(format!(
        "column {name:?}: expected a name that is no number, without quotes, tabulators and line ends"
    )))
}

fn checked_labels(name: &str, labels: Vec<String>) -> Result<Vec<String>, Failure> {
    match labels.iter().position(|label| label.contains(['\t', '\n', '\r', '"', '\0'])) {
        None => Ok(labels),
        Some(row) => Err(Failure::refused(format!(
            "column `{name}`, row {row}: expected a label without quotes, tabulators and line ends"
        ))),
    }
}
