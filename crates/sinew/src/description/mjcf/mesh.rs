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

/// Reads a `<mesh>` of `<asset>`.
pub(super) fn read(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = import.attributes(element, None)?;
    let quaternion = at.array_or("refquat", turn::IDENTITY)?;
    let scale = at.array_or("scale", [1.0; 3])?;
    let reference_position = at.array_or("refpos", [0.0; 3])?;
    let reference_orientation = turn::unit(quaternion)
        .ok_or_else(|| at.error("refquat", "has no direction: expected a vector that is not zero"))?;
    // Its body and its place there are those of the geoms that show it.
    let asset = at.text("file").map(|file| MeshGeom {
        body: 0,
        file: path(&import.compiler, file),
        scale,
        reference_position,
        reference_orientation,
        position: [0.0; 3],
        orientation: turn::IDENTITY,
        surface: None,
    });
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
    let Some(asset) = asset.cloned().flatten() else {
        import.pass_over(at.element, "mesh", "<geom> with a mesh that no file holds: its shape is not drawn");
        return Ok(());
    };
    import.parts.meshes.push(MeshGeom {
        body,
        position: place.position,
        orientation: place.orientation,
        ..asset
    });
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
