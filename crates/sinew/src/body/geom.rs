//! Shapes of bodies, for drawings: plain data, without an effect on dynamics.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Kind of a shape, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GeomKind {
    /// Size: radius.
    Sphere,
    /// A cylinder about z with half spheres at its ends. Size: radius, half length of the cylinder.
    Capsule,
    /// About z. Size: radius, half length.
    Cylinder,
    /// Size: half axes along x, y, z.
    Ellipsoid,
    /// Size: half lengths along x, y, z.
    Box,
}

impl GeomKind {
    /// Every kind with its name in MJCF and in this project's TOML.
    pub const WORDS: [(GeomKind, &'static str); 5] = [
        (GeomKind::Sphere, "sphere"),
        (GeomKind::Capsule, "capsule"),
        (GeomKind::Cylinder, "cylinder"),
        (GeomKind::Ellipsoid, "ellipsoid"),
        (GeomKind::Box, "box"),
    ];

    /// Its name.
    #[must_use]
    pub fn word(self) -> &'static str {
        GeomKind::WORDS.iter().find(|(kind, _)| *kind == self).map_or("sphere", |(_, word)| word)
    }

    /// The kind of a name.
    #[must_use]
    pub fn from_word(word: &str) -> Option<GeomKind> {
        GeomKind::WORDS.iter().find(|(_, known)| *known == word).map(|(kind, _)| *kind)
    }

    /// Number of its sizes.
    #[must_use]
    pub fn sizes(self) -> usize {
        match self {
            GeomKind::Sphere => 1,
            GeomKind::Capsule | GeomKind::Cylinder => 2,
            GeomKind::Ellipsoid | GeomKind::Box => 3,
        }
    }
}

/// A shape fixed to a body: what a drawing shows of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Geom {
    /// The body.
    pub body: usize,
    /// Its kind.
    pub kind: GeomKind,
    /// Sizes by kind, m; those beyond [`GeomKind::sizes`] are zero.
    pub size: [f64; 3],
    /// Centre in the body's frame, m.
    pub position: [f64; 3],
    /// Orientation in the body's frame.
    pub orientation: [f64; 4],
}

/// A shape fixed to a body that a file of triangles describes: what a drawing shows of it.
///
/// A point `v` of the file lies at
/// `position + R(orientation) S R(reference_orientation)^T (v - reference_position)` in the body's frame, `S`
/// the diagonal matrix of `scale`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshGeom {
    /// The body.
    pub body: usize,
    /// Path of the file, relative to the folder of the file that describes the robot, or a URI of ROS.
    pub file: String,
    /// Metres in a unit of the file, along x, y, z; below zero where the file is mirrored.
    pub scale: [f64; 3],
    /// Point of the file at the origin of the shape.
    pub reference_position: [f64; 3],
    /// Orientation of the shape in the file.
    pub reference_orientation: [f64; 4],
    /// Origin of the shape in the body's frame, m.
    pub position: [f64; 3],
    /// Orientation in the body's frame.
    pub orientation: [f64; 4],
    /// Its triangles, where the file was read.
    #[serde(skip)]
    pub surface: Option<Arc<TriangleSurface>>,
}

/// Triangles in the frame of a shape, m.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleSurface {
    /// Corners.
    pub vertices: Vec<[f32; 3]>,
    /// Indices of three corners each, anticlockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}
