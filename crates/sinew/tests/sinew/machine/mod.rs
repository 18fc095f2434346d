//! Machine files: what is read is what was written, what is missing is a default, and what is wrong is
//! refused with its place.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod clearance;
mod demand;
mod deviations;
mod extreme;
mod files;
mod holding;
mod models;
mod routing;
mod stability;
mod unlawful;
mod wrong;

use sinew::description::machine::{BusKeys, BusReader, FileReference, Listing, Table, machine_on_bus};
use sinew::description::{DescriptionError, MachineDescription};

/// A bus whose devices have roles and nothing else.
struct RolesAlone;

impl BusReader for RolesAlone {
    fn keys(&self) -> BusKeys {
        BusKeys::default()
    }

    fn read(&mut self, _: &Table<'_>, _: &[Table<'_>], _: &mut Listing) -> Result<(), DescriptionError> {
        Ok(())
    }
}

/// A machine without other files.
pub(crate) fn read(text: &str) -> Result<MachineDescription, DescriptionError> {
    let read = &mut |file: FileReference<'_>| Err(format!("{} is not here", file.path));
    machine_on_bus("machine.toml", text, read, &mut RolesAlone)
}

/// A machine of this repository.
pub(crate) fn model(name: &str) -> MachineDescription {
    let path = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    read(&std::fs::read_to_string(path).unwrap()).unwrap()
}
