//! One cable in its sheath.

use crate::array::{Numbers, array, vector, wrong_shape};
use crate::failure::Failure;
use crate::long_call;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{CableLaw, CableParameters, CablePath, EndMotion, EndTensions, NodeLaw};

/// Tensions at the ends of a cable after a step.
#[pyclass(frozen, module = "sinew")]
#[derive(Clone)]
pub(crate) struct CableEnds(EndTensions);

#[pymethods]
impl CableEnds {
    /// Tension at the drive's outlet, N.
    #[getter]
    fn tension_in(&self) -> f64 {
        self.0.tension_in
    }

    /// Tension at the anchor, N.
    #[getter]
    fn tension_out(&self) -> f64 {
        self.0.tension_out
    }

    /// Energy dissipated by friction in the step, J.
    #[getter]
    fn dissipated(&self) -> f64 {
        self.0.dissipated
    }

    fn __repr__(&self) -> String {
        let EndTensions { tension_in, tension_out, dissipated } = self.0;
        format!(
            "CableEnds(tension_in={tension_in:?}, tension_out={tension_out:?}, dissipated={dissipated:?})"
        )
    }
}

/// An elastic cable with friction in its sheath, cut into cells; see `sinew.Cable`.
#[pyclass(subclass, module = "sinew._sinew")]
pub(crate) struct Cable {
    inner: sinew::transmission::cable::Cable,
}

#[pymethods]
impl Cable {
    /// `path` and `parameters` as JSON; those of the bench where they are none.
    #[new]
    fn new(path: Option<&str>, parameters: Option<&str>, cells: usize) -> PyResult<Self> {
        let refused = |what: &str, e: serde_json::Error| Failure::refused(format!("{what}: {e}"));
        let path = match path {
            None => CablePath::bench(),
            Some(text) => serde_json::from_str(text).map_err(|e| refused("path", e))?,
        };
        let parameters: CableParameters = match parameters {
            None => CableParameters::bench(),
            Some(text) => serde_json::from_str(text).map_err(|e| refused("parameters", e))?,
        };
        let law = CableLaw::new(&path, &parameters, cells).map_err(Failure::from)?;
        Ok(Self { inner: sinew::transmission::cable::Cable::new(law) })
    }

    /// The parameters of the bench as JSON.
    #[staticmethod]
    fn bench_parameters() -> PyResult<String> {
        Ok(serde_json::to_string(&CableParameters::bench()).map_err(Failure::from)?)
    }

    /// Advances the cable by `interval_s` seconds, 1e-7 to 0.02, while its ends move.
    ///
    /// `motor_m`, `anchor_m`: displacements of winch and anchor in this step, m, positive toward the motor,
    /// at most 0.1.
    #[pyo3(signature = (interval_s, motor_m, anchor_m=0.0))]
    fn step(&mut self, interval_s: f64, motor_m: f64, anchor_m: f64) -> PyResult<CableEnds> {
        let motion = EndMotion { motor: motor_m, anchor: anchor_m };
        Ok(CableEnds(self.inner.step(interval_s, motion).map_err(Failure::from)?))
    }

    /// Many steps, one after the other.
    ///
    /// `motor_m`, `anchor_m`: displacements in every step, m, shapes `(n,)`; without `anchor_m` the anchor
    /// stands still. Returns a dictionary of arrays of shape `(n,)`: `tension_in`, N, `tension_out`, N,
    /// `dissipated`, J, and `stretch`, m. After an error the cable is where its last good step left it.
    #[pyo3(signature = (interval_s, motor_m, anchor_m=None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        interval_s: f64,
        motor_m: &Bound<'py, PyAny>,
        anchor_m: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let motor = Numbers::from_python(motor_m, "motor_m")?;
        let [count] = *motor.shape() else {
            return Err(wrong_shape("motor_m", "(n,)", motor.shape()).into());
        };
        let anchor = anchor_m.map(|value| Numbers::from_python(value, "anchor_m")).transpose()?;
        let anchor = anchor.as_ref().map(|anchor| anchor.row("anchor_m", count)).transpose()?;
        let motor = motor.slice()?;
        let mut columns = [const { Vec::new() }; 4];
        let cable = &mut self.inner;
        long_call::for_each(py, count, |k| {
            let motion = EndMotion { motor: motor[k], anchor: anchor.map_or(0.0, |anchor| anchor[k]) };
            let ends = cable.step(interval_s, motion).map_err(|error| long_call::at(count, k, &error))?;
            let row = [ends.tension_in, ends.tension_out, ends.dissipated, cable.stretch()];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            Ok(())
        })?;
        let result = PyDict::new(py);
        for (name, column) in ["tension_in", "tension_out", "dissipated", "stretch"].into_iter().zip(columns)
        {
            result.set_item(name, PyArray1::from_vec(py, column))?;
        }
        Ok(result)
    }

    /// Sets the profile of steady sliding with this tension at the anchor, N; `toward_motor` is the direction
    /// of sliding.
    #[pyo3(signature = (tension_out_n, *, toward_motor=true))]
    fn settle(&mut self, tension_out_n: f64, toward_motor: bool) -> PyResult<CableEnds> {
        let sliding = if toward_motor { Sliding::TowardMotor } else { Sliding::AwayFromMotor };
        self.inner.settle(tension_out_n, sliding).map_err(Failure::from)?;
        Ok(self.ends())
    }

    /// Tensions at the ends after the last step.
    #[getter]
    fn ends(&self) -> CableEnds {
        CableEnds(self.inner.ends())
    }

    /// Tension of every cell, N, drive end first, shape `(cells,)`.
    #[getter]
    fn tensions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.inner.tensions().collect::<Vec<_>>())
    }

    /// Slip of every node in the last step, m, positive toward the motor, shape `(cells - 1,)`.
    #[getter]
    fn slips<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.inner.slips().collect::<Vec<_>>())
    }

    /// Total stretch, m; negative by the slack of a slack cable.
    #[getter]
    fn stretch(&self) -> f64 {
        self.inner.stretch()
    }

    /// Elastic energy, J, without that of the pretension.
    #[getter]
    fn energy(&self) -> f64 {
        self.inner.energy()
    }

    /// The law as arrays, drive end first: `compliance`, m/N, shape `(cells,)`; of every node, shape
    /// `(cells - 1,)`, `friction`, the half angle `mu phi / 2`, `loss`, `-ln(efficiency) / 2`, `viscous`,
    /// s/m, and `drag`, N s/m; `drag_fade` and `pretension`, N, shape `()`.
    #[getter]
    fn law<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (law, found) = (self.inner.law(), PyDict::new(py));
        found.set_item("compliance", vector(py, law.compliance()))?;
        let column = |name: &str, of: fn(&NodeLaw) -> f64| {
            found.set_item(name, PyArray1::from_iter(py, law.nodes().iter().map(of)))
        };
        column("friction", |node| node.friction)?;
        column("loss", |node| node.loss)?;
        column("viscous", |node| node.viscous)?;
        column("drag", |node| node.drag)?;
        let [_, fade] = law.drag();
        for (name, value) in [("drag_fade", fade), ("pretension", law.pretension())] {
            found.set_item(name, array(py, vec![value], &[], &[])?)?;
        }
        Ok(found)
    }

    /// Travel of the winch, m, that brings the anchor to a tension, N, while it stands still.
    #[pyo3(signature = (tension_out_n, *, toward_motor=true))]
    fn travel_to(&self, tension_out_n: f64, toward_motor: bool) -> PyResult<f64> {
        let sliding = if toward_motor { Sliding::TowardMotor } else { Sliding::AwayFromMotor };
        Ok(self.inner.travel_to(tension_out_n, sliding).map_err(Failure::from)?)
    }

    /// Takes over the state of another cable of the same law.
    fn _assign(&mut self, other: &Bound<'_, Self>) -> PyResult<()> {
        self.inner = other.try_borrow()?.inner.clone();
        Ok(())
    }
}
