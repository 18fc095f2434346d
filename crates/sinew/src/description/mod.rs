//! Robot files: text in, [`crate::body::Parts`] or one error out; and back.
//!
//! Nothing here accesses a file system: the caller passes text, and resolves the names of included files. The
//! result is a description; [`Description::robot`] validates it.

mod attributes;
mod error;
mod mjcf;
mod names;
mod orientation;
mod origin;
mod robot_toml;
mod tree;
mod urdf;

pub use error::{DescriptionError, Warning};
pub use mjcf::{from_mjcf, to_mjcf};
pub use origin::Origins;
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
