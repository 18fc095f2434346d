//! The way to the plugins for MuJoCo: the loader is Python's, which knows where MuJoCo's library is.

use pyo3::prelude::*;
use sinew_mujoco::FieldKind;

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
