//! Shapes of URDF links: boxes, cylinders, spheres, capsules and files of triangles of `<visual>`.

use super::attributes::Attributes;
use super::error::DescriptionError;
use super::orientation::IDENTITY;
use super::tree::Tree;
use crate::body::{Geom, GeomKind, MeshGeom, Parts};

/// Position and orientation of an element by its `<origin>`.
type Origin = fn(&Tree, usize) -> Result<([f64; 3], [f64; 4]), DescriptionError>;

/// Adds the shapes of a link, for drawings.
pub(super) fn read(
    tree: &Tree,
    link: usize,
    body: usize,
    origin: Origin,
    parts: &mut Parts,
) -> Result<(), DescriptionError> {
    let within = |element: usize, name: &'static str| {
        tree.elements[element].children.iter().copied().filter(move |&e| tree.elements[e].name == name)
    };
    for visual in within(link, "visual") {
        let (position, orientation) = origin(tree, visual)?;
        for geometry in within(visual, "geometry") {
            for &shape in &tree.elements[geometry].children {
                let at = Attributes::own(tree, shape);
                let kind = match tree.elements[shape].name.as_str() {
                    "box" => GeomKind::Box,
                    "cylinder" => GeomKind::Cylinder,
                    "capsule" => GeomKind::Capsule,
                    "sphere" => GeomKind::Sphere,
                    "mesh" => {
                        let Some(file) = at.text("filename") else { continue };
                        parts.meshes.push(MeshGeom {
                            body,
                            file: file.into(),
                            scale: at.array_or("scale", [1.0; 3])?,
                            reference_position: [0.0; 3],
                            reference_orientation: IDENTITY,
                            position,
                            orientation,
                            surface: None,
                        });
                        continue;
                    }
                    _ => continue,
                };
                let size = match kind {
                    GeomKind::Box => at.array_or("size", [0.0; 3])?.map(|length| length / 2.0),
                    GeomKind::Sphere => [at.number_or("radius", 0.0)?, 0.0, 0.0],
                    _ => [at.number_or("radius", 0.0)?, at.number_or("length", 0.0)? / 2.0, 0.0],
                };
                // A drawing does without a shape that is none; the robot is valid nevertheless.
                if size[..kind.sizes()].iter().all(|size| *size > 0.0 && size.is_finite()) {
                    parts.geoms.push(Geom { body, kind, size, position, orientation });
                }
            }
        }
    }
    Ok(())
}
