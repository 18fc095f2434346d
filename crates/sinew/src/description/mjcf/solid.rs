//! Solids: the mass of a geom in its body.

use super::mesh_asset::MeshWeight;

/// A massive solid in its body: principal moments about its own axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    pub(super) mass: f64,
    pub(super) position: [f64; 3],
    pub(super) orientation: [f64; 4],
    pub(super) inertia: [f64; 3],
}

/// Contribution of a geom to the mass of its body.
pub(super) enum Weight {
    Nothing,
    Solid(Solid),
    Mesh(MeshWeight),
    /// A solid that is fitted to a mesh.
    Unknown,
}

/// Types of geoms; the first five are solids.
pub(super) const TYPES: [&str; 9] =
    ["sphere", "capsule", "cylinder", "ellipsoid", "box", "plane", "hfield", "mesh", "sdf"];
