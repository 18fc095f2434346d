//! Robot files: text in, [`crate::body::Parts`] or one error out; and back.
//!
//! Nothing here reads a file: whoever has a file system hands over text, and answers for the names that
//! `include` asks for. What is read is a description; [`Description::robot`] judges it as a robot.

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

/// A description and what of its file was passed over.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// What the file says.
    pub parts: crate::body::Parts,
    /// What it also says and is not used here.
    pub warnings: alloc::vec::Vec<Warning>,
    /// Where its parts are described.
    pub origins: Origins,
}
