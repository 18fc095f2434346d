//! Machine files: what is read is what was written, what is missing is a default, and what is wrong is refused
//! with its place.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod clearance;
mod demand;
mod extreme;
mod files;
mod holding;
mod models;
mod routing;
mod stability;
mod unlawful;
mod wrong;

use sinew::description::{DescriptionError, MachineDescription, machine_from_toml};

/// A machine without other files.
pub(crate) fn read(text: &str) -> Result<MachineDescription, DescriptionError> {
    machine_from_toml("machine.toml", text, &mut |file| Err(format!("{} is not here", file.path)))
}

/// A machine of this repository.
pub(crate) fn model(name: &str) -> MachineDescription {
    let path = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    read(&std::fs::read_to_string(path).unwrap()).unwrap()
}
