//! Robot files: text in, [`crate::body::Parts`] or one error out; and back. Machine files: text in, a
//! [`crate::machine::Machine`] with the origin of every value out; their format is documented at [`machine`].
//! Catalogues of drives: text in, a [`crate::drive::Catalogue`] out.
//!
//! Nothing here accesses a file system: the caller passes text, and resolves the names of other files. The
//! result of a robot file is a description; [`Description::robot`] validates it. A robot file is a machine
//! file with defaults for everything but the body ([`machine_of`], [`machine_from_toml`]).

mod attributes;
mod document;
mod domain;
mod error;
pub mod machine;
mod mesh_file;
mod mjcf;
mod names;
mod orientation;
mod origin;
mod osim;
mod robot_toml;
mod spelling;
mod tree;
mod urdf;
mod urdf_geoms;

pub use error::{DescriptionError, Warning};
pub use machine::{MachineDescription, machine_from_toml, machine_of, robot_from_toml};
pub use mjcf::{from_mjcf, to_mjcf};
pub use origin::Origins;
pub use osim::from_osim;
pub use robot_toml::{from_toml, to_toml};
pub use urdf::from_urdf;

/// A description, and warnings about ignored content of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// The described parts.
    pub parts: crate::body::Parts,
    /// Ignored content.
    pub warnings: alloc::vec::Vec<Warning>,
    /// File and line of the parts.
    pub origins: Origins,
}
