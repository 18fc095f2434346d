//! What is known of a mesh and of geoms that show it.

use super::mesh_mass::{MeshLaw, MeshMass, Triangles};
use super::place::Place;
use crate::body::MeshGeom;
use crate::description::attributes::Attributes;
use alloc::string::{String, ToString};

/// A `<mesh>` of `<asset>`.
#[derive(Debug, Clone)]
pub(super) struct MeshAsset {
    pub(super) element: usize,
    /// Its file, in its own frame; without a name where the triangles stand in the model or MuJoCo makes
    /// them.
    pub(super) shape: MeshGeom,
    /// Triangles that stand in the model, in the coordinates of a file.
    pub(super) within: Option<Triangles>,
    pub(super) law: MeshLaw,
    /// Its mass, once a body has needed it.
    pub(super) mass: Option<MeshMass>,
}

/// A geom whose mass is that of a mesh.
#[derive(Debug, Clone)]
pub(super) struct MeshWeight {
    pub(super) element: usize,
    pub(super) mesh: String,
    pub(super) place: Place,
    pub(super) mass: Option<f64>,
    pub(super) density: f64,
}

impl MeshWeight {
    /// Of a geom that shows a mesh.
    pub(super) fn new(at: Attributes<'_>, place: Place, mass: Option<f64>, density: f64) -> Option<Self> {
        let mesh = at.text("mesh")?.to_string();
        Some(Self { element: at.element, mesh, place, mass, density })
    }
}
