//! Meshes: the files of shapes, for drawings.

use super::compiler::Compiler;
use super::import_state::Import;
use super::place::Place;
use crate::body::MeshGeom;
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::mesh_file::joined;
use crate::description::orientation as turn;
use alloc::string::{String, ToString};

/// A file of triangles, and how its coordinates are to be understood.
pub(super) struct MeshAsset {
    /// None where the triangles stand in the model itself or are made by MuJoCo.
    file: Option<String>,
    scale: [f64; 3],
    reference_position: [f64; 3],
    reference_orientation: [f64; 4],
}

/// Reads a `<mesh>` of `<asset>`.
pub(super) fn read(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = import.attributes(element, None)?;
    let quaternion = at.array_or("refquat", turn::IDENTITY)?;
    let asset = MeshAsset {
        file: at.text("file").map(|file| path(&import.compiler, file)),
        scale: at.array_or("scale", [1.0; 3])?,
        reference_position: at.array_or("refpos", [0.0; 3])?,
        reference_orientation: turn::unit(quaternion)
            .ok_or_else(|| at.error("refquat", "has no direction: expected a vector that is not zero"))?,
    };
    let name = import.name("mesh", at)?.or_else(|| at.text("file").map(stem));
    if let Some(name) = name {
        import.meshes.insert(name, asset);
    }
    Ok(())
}

/// Adds the shape of a geom with a mesh; a shape that cannot be drawn is no reason to refuse a robot.
pub(super) fn shape(
    import: &mut Import<'_>,
    at: Attributes<'_>,
    body: usize,
    place: Place,
    group: f64,
) -> Result<(), DescriptionError> {
    let asset = at.text("mesh").and_then(|name| import.meshes.get(name));
    let Some((asset, file)) = asset.and_then(|asset| Some((asset, asset.file.clone()?))) else {
        import.pass_over(at.element, "mesh", "<geom> with a mesh that no file holds: its shape is not drawn");
        return Ok(());
    };
    let mesh = MeshGeom {
        body,
        file,
        scale: asset.scale,
        reference_position: asset.reference_position,
        reference_orientation: asset.reference_orientation,
        position: place.position,
        orientation: place.orientation,
        surface: None,
    };
    import.parts.meshes.push(mesh);
    import.mesh_groups.push(group);
    Ok(())
}

fn path(compiler: &Compiler, file: &str) -> String {
    let file = file.replace('\\', "/");
    let name = if compiler.strip_path { file.rsplit('/').next().unwrap_or_default() } else { &file };
    joined(&compiler.mesh_folder, name)
}

/// Name of a file without its folder and extension.
fn stem(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_string()
}
