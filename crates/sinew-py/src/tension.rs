//! Distribution of torques over muscles, one problem or many.

use crate::array::{Numbers, array, wrong_shape};
use crate::failure::Failure;
use crate::long_call;
use numpy::PyArray1;
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::control::tension::{Distribution, Problem, Status};

/// An argument with or without the axis of the problems.
struct Part<'py> {
    numbers: Numbers<'py>,
    each: bool,
    size: usize,
}

impl<'py> Part<'py> {
    /// An argument whose axes, without that of the problems, are `tail`.
    fn from_python(
        value: &Bound<'py, PyAny>,
        name: &str,
        tail: &[usize],
        count: &mut Option<usize>,
    ) -> PyResult<Self> {
        let numbers = Numbers::from_python(value, name)?;
        let each = numbers.shape().len() == tail.len() + 1;
        let own = if each { &numbers.shape()[1..] } else { numbers.shape() };
        let desired = count.map_or_else(|| "n".to_owned(), |n| n.to_string());
        let tail_text = tail.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let refused =
            || wrong_shape(name, &format!("({tail_text}) or ({desired}, {tail_text})"), numbers.shape());
        if own != tail {
            return Err(refused().into());
        }
        if each {
            let first = numbers.shape()[0];
            if count.is_some_and(|n| n != first) {
                return Err(refused().into());
            }
            *count = Some(first);
        }
        Ok(Self { each, size: tail.iter().product(), numbers })
    }

    fn view(&self) -> PyResult<View<'_>> {
        Ok(View { data: self.numbers.slice()?, each: self.each, size: self.size })
    }
}

#[derive(Clone, Copy)]
struct View<'a> {
    data: &'a [f64],
    each: bool,
    size: usize,
}

impl<'a> View<'a> {
    fn of(&self, problem: usize) -> &'a [f64] {
        let start = if self.each { problem * self.size } else { 0 };
        &self.data[start..start + self.size]
    }
}

/// Distributes torques; see `sinew.distribute`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "positional here, keywords in the Python face")]
pub(crate) fn distribute<'py>(
    py: Python<'py>,
    moment_arms: &Bound<'py, PyAny>,
    torque: &Bound<'py, PyAny>,
    minimum: &Bound<'py, PyAny>,
    maximum: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
    weight: &Bound<'py, PyAny>,
    warm_start: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let arms = Numbers::from_python(moment_arms, "moment_arms")?;
    let (muscles, joints) = match *arms.shape() {
        [muscles, joints] | [_, muscles, joints] => (muscles, joints),
        _ => {
            return Err(wrong_shape(
                "moment_arms",
                "(muscles, joints) or (n, muscles, joints)",
                arms.shape(),
            )
            .into());
        }
    };
    let mut count = None;
    let mut part = |value, name, tail: &[usize]| Part::from_python(value, name, tail, &mut count);
    let arms = part(moment_arms, "moment_arms", &[muscles, joints])?;
    let torque = part(torque, "torque", &[joints])?;
    let minimum = part(minimum, "minimum", &[muscles])?;
    let maximum = part(maximum, "maximum", &[muscles])?;
    let reference = part(reference, "reference", &[muscles])?;
    let weight = part(weight, "weight", &[muscles])?;
    let views = [&arms, &torque, &minimum, &maximum, &reference, &weight];
    let [arms, torque, minimum, maximum, reference, weight] = views.map(Part::view);
    let (arms, torque, minimum) = (arms?, torque?, minimum?);
    let (maximum, reference, weight) = (maximum?, reference?, weight?);
    let lead: Vec<usize> = count.into_iter().collect();
    let count = count.unwrap_or(1);

    let (mut tension, mut residual) = (vec![0.0; count * muscles], vec![0.0; count * joints]);
    let (mut status, mut iterations) = (vec![0_i8; count], vec![0_u32; count]);
    let mut distribution = Distribution::new(muscles, joints);
    let solve = |k: usize| {
        if !warm_start {
            // So that a problem has the same bits alone and among others.
            distribution.forget();
        }
        let problem = Problem {
            moment_arms: arms.of(k),
            torque: torque.of(k),
            minimum: minimum.of(k),
            maximum: maximum.of(k),
            reference: reference.of(k),
            weight: weight.of(k),
        };
        let solution = distribution.solve(&problem).map_err(|error| long_call::at(count, k, &error))?;
        tension[k * muscles..(k + 1) * muscles].copy_from_slice(solution.tension);
        residual[k * joints..(k + 1) * joints].copy_from_slice(solution.residual);
        iterations[k] = solution.iterations;
        status[k] = match solution.status {
            Status::Optimal => 0,
            Status::Infeasible => 1,
            Status::NotConverged => 2,
        };
        Ok::<(), Failure>(())
    };
    long_call::for_each(py, count, solve)?;
    let result = PyDict::new(py);
    result.set_item("tension", array(py, tension, &lead, &[muscles])?)?;
    result.set_item("residual", array(py, residual, &lead, &[joints])?)?;
    result.set_item("status", PyArray1::from_vec(py, status).reshape(lead.clone())?)?;
    result.set_item("iterations", PyArray1::from_vec(py, iterations).reshape(lead)?)?;
    Ok(result)
}
