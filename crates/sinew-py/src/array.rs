//! NumPy arrays in and out: float64 and C-contiguous without a copy, all other numbers with one.

use crate::failure::Failure;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An array of numbers that came from Python.
pub(crate) struct Numbers<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
}

impl<'py> Numbers<'py> {
    /// The numbers of an array, or of anything that NumPy makes one of; `name` stands in errors.
    pub(crate) fn from_python(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        if let Ok(array) = value.cast::<PyArrayDyn<f64>>() {
            let array = array.try_readonly().map_err(|e| Failure::Internal(e.to_string()))?;
            if array.is_c_contiguous() && array.as_slice().is_ok() {
                return Ok(Self { array });
            }
        }
        let array = converted(value, name)?;
        let array = array.cast::<PyArrayDyn<f64>>()?.try_readonly();
        Ok(Self { array: array.map_err(|e| Failure::Internal(e.to_string()))? })
    }

    /// In C order.
    pub(crate) fn slice(&self) -> PyResult<&[f64]> {
        self.array.as_slice().map_err(|e| Failure::Internal(e.to_string()).into())
    }

    pub(crate) fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// As one row of `width` numbers.
    pub(crate) fn row(&self, name: &str, width: usize) -> PyResult<&[f64]> {
        if self.shape() != [width] {
            return Err(wrong_shape(name, &format!("({width},)"), self.shape()).into());
        }
        self.slice()
    }
}

/// One copy as float64 in C order; text, objects and complex numbers are refused.
fn converted<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let numpy = value.py().import("numpy")?;
    let any = numpy.call_method1("asarray", (value,))?;
    let dtype = any.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "b" | "i" | "u" | "f") {
        return Err(PyTypeError::new_err(format!("{name} must be real numbers, but is an array of {dtype}")));
    }
    let options = PyDict::new(value.py());
    options.set_item("dtype", "float64")?;
    options.set_item("order", "C")?;
    // A writable copy of its own, aligned whatever the origin.
    numpy.call_method("array", (any,), Some(&options))
}

pub(crate) fn wrong_shape(name: &str, expected: &str, got: &[usize]) -> Failure {
    Failure::refused(format!("{name} must have the shape {expected}, but has {}", shape_text(got)))
}

fn shape_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        many => format!("({})", many.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// Rows of equal width over any leading axes: `(..., width)`.
pub(crate) struct Rows<'py> {
    numbers: Numbers<'py>,
    name: &'static str,
    width: usize,
}

impl<'py> Rows<'py> {
    /// The array as rows.
    pub(crate) fn from_python(value: &Bound<'py, PyAny>, name: &'static str, width: usize) -> PyResult<Self> {
        let numbers = Numbers::from_python(value, name)?;
        if numbers.shape().last() != Some(&width) {
            return Err(wrong_shape(name, &format!("(..., {width})"), numbers.shape()).into());
        }
        Ok(Self { numbers, name, width })
    }

    /// The leading axes.
    pub(crate) fn lead(&self) -> &[usize] {
        let shape = self.numbers.shape();
        &shape[..shape.len() - 1]
    }

    /// The rows, in which a single row stands for as many as the others have.
    pub(crate) fn view(&self) -> PyResult<RowView<'_>> {
        Ok(RowView { data: self.numbers.slice()?, width: self.width, single: self.lead().is_empty() })
    }
}

/// Rows as they are read without the interpreter.
#[derive(Clone, Copy)]
pub(crate) struct RowView<'a> {
    data: &'a [f64],
    width: usize,
    single: bool,
}

impl<'a> RowView<'a> {
    #[inline]
    pub(crate) fn row(&self, index: usize) -> &'a [f64] {
        let start = if self.single { 0 } else { index * self.width };
        &self.data[start..start + self.width]
    }
}

/// The leading axes that arguments have in common: each has them, or is a single row.
pub(crate) fn common_lead(all: &[&Rows<'_>]) -> Result<Vec<usize>, Failure> {
    let mut common: Option<&Rows<'_>> = None;
    for rows in all.iter().filter(|rows| !rows.lead().is_empty()) {
        match common {
            Some(first) if first.lead() != rows.lead() => {
                return Err(Failure::refused(format!(
                    "{} and {} must have the same leading axes, but have {} and {}",
                    first.name,
                    rows.name,
                    shape_text(first.lead()),
                    shape_text(rows.lead())
                )));
            }
            _ => common = Some(rows),
        }
    }
    Ok(common.map_or_else(Vec::new, |rows| rows.lead().to_vec()))
}

/// Numbers as an array of the shape `(*lead, *tail)`, which takes them over without a copy.
pub(crate) fn array<'py>(
    py: Python<'py>,
    data: Vec<f64>,
    lead: &[usize],
    tail: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let shape: Vec<usize> = lead.iter().chain(tail).copied().collect();
    PyArray1::from_vec(py, data).reshape(shape)
}

/// The same with one axis.
pub(crate) fn vector<'py>(py: Python<'py>, data: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, data)
}
