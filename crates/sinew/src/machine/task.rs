use crate::trajectory::EndPointPath;
use alloc::string::String;

/// What a machine tracks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Coordinates of an end point.
    EndPoint {
        /// Index of its site.
        site: usize,
        /// Which of x, y and z are tracked, in the world.
        axes: [bool; 3],
    },
    /// The joints.
    Joints,
}

impl Task {
    /// Index of the end point's site, if there is one.
    #[must_use]
    pub fn site(self) -> Option<usize> {
        match self {
            Self::EndPoint { site, .. } => Some(site),
            Self::Joints => None,
        }
    }
}

/// A closed path of the end point that belongs to a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPath {
    /// Unique in its machine.
    pub name: String,
    /// The path.
    pub path: EndPointPath,
}
