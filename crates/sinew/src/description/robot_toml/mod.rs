//! This project's own format: TOML, SI units, units in the names of keys, references by name.

mod export;
mod import;
mod top_level;

pub use export::to_toml;
pub use import::from_toml;
pub(super) use import::{add_muscles, add_springs, description, spring_tables};
pub(super) use top_level::{MACHINE_KEYS, ROBOT_KEYS};
