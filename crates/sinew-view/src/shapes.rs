//! What is drawn of the bodies of a robot: their shapes, bones where the file has none, surfaces that cables
//! wrap.

use crate::meshes::{extent, surfaces, turned};
use serde::Serialize;
use sinew::body::{Geom, MeshGeom, Parts, PathElement, TendonPath, WrapKind};
use std::sync::Arc;

/// Radius of a bone, as a fraction of the mean length of all, and at most as a fraction of its own.
const BONE_FRACTION: f64 = 0.085;
const THICKEST: f64 = 0.3;
/// Half length of a cylinder that cables wrap, as a multiple of its radius: in the model it has no end.
const SURFACE_FRACTION: f64 = 1.2;

/// A shape in the frame of its body, as the page reads it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shape {
    /// The body, 0 for the world.
    pub body: usize,
    /// `sphere`, `capsule`, `cylinder`, `box`, `ellipsoid`, `bone` or `mesh`.
    pub kind: &'static str,
    /// Half lengths as in MJCF, m: the radius first, then the half length without the ends of a capsule or
    /// bone. Of a mesh those of the box around it.
    pub size: [f64; 3],
    /// Of its centre, m.
    pub position: [f64; 3],
    /// Unit quaternion `[w, x, y, z]`; cylinders, capsules and bones lie along z.
    pub quaternion: [f64; 4],
    /// Whether it is a surface that cables wrap.
    pub wrap: bool,
    /// Index of its triangles among [`crate::meshes`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
}

impl Shape {
    /// Corners of the box around it, in the frame of its body, m.
    #[must_use]
    pub fn corners(&self) -> [[f64; 3]; 8] {
        let [a, b, c] = match self.kind {
            "sphere" => [self.size[0]; 3],
            "cylinder" => [self.size[0], self.size[0], self.size[1]],
            "capsule" | "bone" => [self.size[0], self.size[0], self.size[0] + self.size[1]],
            _ => self.size,
        };
        std::array::from_fn(|k| {
            let side = |bit: usize, half: f64| if k >> bit & 1 == 0 { -half } else { half };
            let corner = turned(self.quaternion, [side(0, a), side(1, b), side(2, c)]);
            std::array::from_fn(|i| self.position[i] + corner[i])
        })
    }
}

/// Shapes of all bodies. Of the world what is not larger than the robot: a floor would hide it. A body
/// without a shape gets bones from its origin to the bodies that it carries, or to its farthest site, or to
/// twice its centre of mass.
#[must_use]
pub fn shapes(parts: &Parts) -> Vec<Shape> {
    let described = parts.geoms.iter().map(|geom: &Geom| Shape {
        body: geom.body,
        kind: geom.kind.word(),
        size: geom.size,
        position: geom.position,
        quaternion: geom.orientation,
        wrap: false,
        mesh: None,
    });
    let described: Vec<Shape> = described.chain(files(parts)).collect();
    let moving = described.iter().filter(|shape| shape.body > 0).flat_map(Shape::corners);
    let reach = parts.bodies.iter().map(|body| norm(body.position)).sum::<f64>()
        + moving.map(norm).fold(0.0, f64::max);
    let small = |shape: &Shape| shape.body > 0 || shape.size.iter().all(|size| *size <= reach);
    let wrapped = parts.wraps.iter().map(|wrap| {
        let (kind, length) = match wrap.kind {
            WrapKind::Cylinder => ("cylinder", SURFACE_FRACTION * wrap.radius),
            WrapKind::Sphere => ("sphere", wrap.radius),
        };
        Shape {
            body: wrap.body,
            kind,
            size: [wrap.radius, length, length],
            position: wrap.position,
            quaternion: wrap.orientation,
            wrap: true,
            mesh: None,
        }
    });
    described.into_iter().filter(small).chain(bones(parts)).chain(wrapped).collect()
}

/// The shapes of files that were read.
fn files(parts: &Parts) -> Vec<Shape> {
    let known = surfaces(parts);
    let of = |mesh: &MeshGeom| {
        let surface = mesh.surface.as_ref()?;
        let (centre, size) = extent(surface);
        let centre = turned(mesh.orientation, centre);
        Some(Shape {
            body: mesh.body,
            kind: "mesh",
            size,
            position: std::array::from_fn(|k| mesh.position[k] + centre[k]),
            quaternion: mesh.orientation,
            wrap: false,
            mesh: known.iter().position(|other| Arc::ptr_eq(other, surface)),
        })
    };
    parts.meshes.iter().filter_map(of).collect()
}

/// Bones of the bodies without shapes, the world's excepted.
fn bones(parts: &Parts) -> Vec<Shape> {
    let mut ends: Vec<(usize, [f64; 3])> = Vec::new();
    for body in 1..parts.bodies.len() {
        let read = |mesh: &MeshGeom| mesh.body == body && mesh.surface.is_some();
        if parts.geoms.iter().any(|geom| geom.body == body) || parts.meshes.iter().any(read) {
            continue;
        }
        let mut own: Vec<[f64; 3]> = (body + 1..parts.bodies.len())
            .filter(|child| parts.bodies[*child].parent == body)
            .map(|child| parts.bodies[child].position)
            .filter(|end| norm(*end) > 0.0)
            .collect();
        let carries = parts.bodies.iter().skip(1).any(|other| other.parent == body);
        if !carries {
            let sites = parts
                .sites
                .iter()
                .enumerate()
                .filter(|(index, site)| site.body == body && !side(parts, *index));
            let farthest = sites.map(|(_, site)| site.position).max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
            // Without a site, as far behind the centre of mass as that is from the joint.
            own.push(farthest.unwrap_or_else(|| parts.bodies[body].center_of_mass.map(|x| 2.0 * x)));
        }
        ends.extend(own.into_iter().filter(|end| norm(*end) > 0.0).map(|end| (body, end)));
    }
    let mean = ends.iter().map(|(_, end)| norm(*end)).sum::<f64>() / (ends.len() as f64).max(1.0);
    ends.into_iter().map(|(body, end)| bone(body, end, BONE_FRACTION * mean)).collect()
}

/// A bone from the origin of a body to a point of it.
fn bone(body: usize, end: [f64; 3], radius: f64) -> Shape {
    let length = norm(end);
    let radius = radius.min(THICKEST * length);
    Shape {
        body,
        kind: "bone",
        size: [radius, (0.5 * length - radius).max(0.0), 0.0],
        position: end.map(|x| 0.5 * x),
        quaternion: from_z(end.map(|x| x / length)),
        wrap: false,
        mesh: None,
    }
}

/// Whether a site only selects the side of a surface: it may lie outside the body.
fn side(parts: &Parts, index: usize) -> bool {
    let elements = || {
        parts.tendons.iter().flat_map(|tendon| match &tendon.path {
            TendonPath::Spatial(elements) => elements.as_slice(),
            TendonPath::Fixed(_) => &[],
        })
    };
    let selects = |element: &PathElement| matches!(element, PathElement::Wrap { side: Some(side), .. } if *side == index);
    elements().any(selects) && !elements().any(|element| *element == PathElement::Site(index))
}

/// The shortest turn of z onto a unit vector.
fn from_z([x, y, z]: [f64; 3]) -> [f64; 4] {
    if z < -1.0 + 1e-12 {
        return [0.0, 1.0, 0.0, 0.0];
    }
    let norm = (2.0 * (1.0 + z)).sqrt();
    [0.5 * norm, -y / norm, x / norm, 0.0]
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z turned by a quaternion.
    fn turned([w, x, y, z]: [f64; 4]) -> [f64; 3] {
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
    }

    #[test]
    fn the_turn_of_z_reaches_every_direction() {
        for k in 0..300 {
            let raw: [f64; 3] = std::array::from_fn(|i| (1.7 * f64::from(k) + 2.3 * i as f64).sin());
            let unit = raw.map(|x| x / norm(raw));
            for (a, b) in turned(from_z(unit)).iter().zip(unit) {
                assert!((a - b).abs() < 1e-9, "{unit:?}");
            }
        }
        assert!((turned(from_z([0.0, 0.0, -1.0]))[2] + 1.0).abs() < 1e-12);
    }

    #[test]
    fn bodies_without_shapes_get_bones_and_cables_their_surfaces() {
        for (name, text) in [
            ("lm_arm", sinew_models::LM_ARM),
            ("finger", sinew_models::FINGER),
            ("chain10", sinew_models::CHAIN10),
        ] {
            let read = sinew::description::robot_from_toml(name, text, &mut |_| Err(String::new())).unwrap();
            let parts = read.0.parts();
            let found = shapes(parts);
            let of = |wrap: bool| found.iter().filter(|shape| shape.wrap == wrap).count();
            assert_eq!(of(true), parts.wraps.len(), "{name}");
            let bodies: Vec<usize> =
                found.iter().filter(|shape| !shape.wrap).map(|shape| shape.body).collect();
            // A body whose joint carries the next one at the same place has no extent.
            let extended = parts.bodies.iter().skip(2).filter(|body| norm(body.position) > 0.0).count();
            assert!(bodies.len() >= extended, "{name}: {bodies:?}");
            for shape in &found {
                let numbers = shape.size.iter().chain(&shape.position).chain(&shape.quaternion);
                assert!(numbers.clone().all(|x| x.is_finite()), "{name}: {shape:?}");
                assert!(shape.size[0] > 0.0, "{name}: {shape:?}");
            }
        }
    }
}
