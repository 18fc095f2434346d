//! The way to the plugins for MuJoCo: the loader is Python's, which knows where MuJoCo's library is.

use crate::failure::Failure;
use crate::machine::Machine;
use pyo3::prelude::*;
use sinew::body::Tendon;
use sinew::description::to_mjcf;
use sinew::machine::MuscleDesign;
use sinew::muscle::MuscleDynamics;
use sinew_mujoco::FieldKind;

/// Free length of a cable whose muscle has none of its own, m.
const SHORTEST: f64 = 1e-3;

/// Address of the function of C that registers the plugins; see `sinew_mujoco::connect_address`.
#[pyfunction]
pub(crate) fn mujoco_connect_address() -> usize {
    sinew_mujoco::connect_address()
}

/// Fields of MuJoCo's structures that the plugins use: path, whether it is a number, whether it is required.
#[pyfunction]
pub(crate) fn mujoco_fields() -> Vec<(&'static str, bool, bool)> {
    let row = |field: &sinew_mujoco::FieldName| (field.path, field.kind == FieldKind::Number, field.required);
    sinew_mujoco::fields().iter().map(row).collect()
}

/// A machine as MJCF with its payload, and as JSON what MJCF does not say: the coordinates of its start and,
/// of every muscle, name, path and parameters of the cable at the start, and the limits of its tension.
#[pyfunction]
pub(crate) fn mujoco_machine(machine: &Bound<'_, Machine>) -> PyResult<(String, String)> {
    let machine = &machine.get().machine;
    let loaded = machine.loaded().map_err(Failure::from)?;
    let robot = &machine.robot;
    let mut model = MuscleDynamics::new(robot).map_err(Failure::from)?;
    model.evaluate(&machine.start).map_err(Failure::from)?;
    let places = model.lengths().iter().enumerate().map(|(k, free)| (free, model.wrap_angle(k)));
    let muscle = |((design, tendon), (free, wrap)): ((&MuscleDesign, &Tendon), (&f64, f64))| {
        let path = design.path(free.max(SHORTEST), wrap).map_err(Failure::from)?;
        Ok(serde_json::json!({
            "name": tendon.name, "path": path, "parameters": design.cable, "tension_n": design.tension,
        }))
    };
    let tendons = &robot.parts().tendons;
    let muscles =
        machine.muscles.iter().zip(tendons).zip(places).map(muscle).collect::<PyResult<Vec<_>>>()?;
    let start = robot.pose_from_independent(&machine.start).map_err(Failure::from)?;
    let described = serde_json::json!({ "start": start, "muscles": muscles });
    Ok((to_mjcf(loaded.robot.parts()), described.to_string()))
}
