//! Triangles of the files that robots name, read and reduced to what a page can hold.

use crate::reduction::reduced;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use sinew::body::{MeshGeom, Parts, Robot, TriangleSurface};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// Triangles of all meshes of a robot together: about 16 bytes each in a page.
const TRIANGLES: usize = 20_000;

/// A surface as the page reads it: little-endian numbers in base64.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct EncodedMesh {
    /// Corners, m, from the centre of the box around them: three `f32` each.
    pub vertices: String,
    /// Three `u16` a triangle.
    pub triangles: String,
}

/// Bytes of a file by its name in the robot's description, or why there are none.
pub type ReadMesh<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// Reads the mesh files that a robot names (STL, OBJ, MSH), with the triangles that a page can hold.
///
/// Returns why files were not read: a robot without them is drawn with less, and works the same.
pub fn read_meshes(robot: &mut Robot, read: &mut ReadMesh<'_>) -> Vec<String> {
    let (mut whole, mut problems) = (Vec::<(MeshGeom, TriangleSurface)>::new(), Vec::new());
    let bits = |x: [f64; 3]| x.map(f64::to_bits);
    let alike = |a: &MeshGeom, b: &MeshGeom| {
        a.file == b.file
            && bits(a.scale) == bits(b.scale)
            && bits(a.reference_position) == bits(b.reference_position)
            && a.reference_orientation.map(f64::to_bits) == b.reference_orientation.map(f64::to_bits)
    };
    let mut refused: Vec<&str> = Vec::new();
    for mesh in &robot.parts().meshes {
        if refused.contains(&mesh.file.as_str()) || whole.iter().any(|(known, _)| alike(known, mesh)) {
            continue;
        }
        match surface_of(&mesh.file, read) {
            Ok(surface) => whole.push((mesh.clone(), placed(surface, mesh))),
            Err(problem) => {
                refused.push(&mesh.file);
                problems.push(format!("{}: {problem}; the body is drawn without it", mesh.file));
            }
        }
    }
    let counts = || whole.iter().map(|(_, surface)| surface.triangles.len());
    let all: usize = counts().sum();
    let roots: f64 = counts().map(|count| (count as f64).sqrt()).sum();
    let read: Vec<(MeshGeom, Arc<TriangleSurface>)> = whole
        .into_iter()
        .map(|(mesh, surface)| {
            // Small parts keep more of their triangles than large ones.
            let fraction = TRIANGLES as f64 * (surface.triangles.len() as f64).sqrt() / roots;
            let surface = if all > TRIANGLES { reduced(surface, fraction as usize) } else { surface };
            (mesh, Arc::new(surface))
        })
        .collect();
    robot.read_meshes(|mesh| {
        read.iter().find(|(known, _)| alike(known, mesh)).map(|(_, surface)| Arc::clone(surface))
    });
    problems
}

/// The surfaces that [`crate::shapes`] refers to by their indices.
#[must_use]
pub fn meshes(parts: &Parts) -> Vec<EncodedMesh> {
    let encode = |surface: &Arc<TriangleSurface>| {
        let (centre, _) = extent(surface);
        let about = |corner: &[f32; 3]| -> [f32; 3] {
            std::array::from_fn(|k| (f64::from(corner[k]) - centre[k]) as f32)
        };
        let vertices: Vec<u8> = surface.vertices.iter().flat_map(about).flat_map(f32::to_le_bytes).collect();
        // `reduced` leaves at most three corners for each of `TRIANGLES`.
        let index = |k: &u32| u16::try_from(*k).unwrap_or(u16::MAX);
        let triangles: Vec<u8> =
            surface.triangles.iter().flatten().flat_map(|k| index(k).to_le_bytes()).collect();
        EncodedMesh { vertices: STANDARD.encode(vertices), triangles: STANDARD.encode(triangles) }
    };
    surfaces(parts).iter().map(encode).collect()
}

/// Centre of the box around a surface, and half its lengths, m.
pub(crate) fn extent(surface: &TriangleSurface) -> ([f64; 3], [f64; 3]) {
    let along = |k: usize| surface.vertices.iter().map(move |corner| f64::from(corner[k]));
    let low: [f64; 3] = std::array::from_fn(|k| along(k).fold(f64::INFINITY, f64::min));
    let high: [f64; 3] = std::array::from_fn(|k| along(k).fold(f64::NEG_INFINITY, f64::max));
    (std::array::from_fn(|k| low[k].midpoint(high[k])), std::array::from_fn(|k| 0.5 * (high[k] - low[k])))
}

/// Every surface once, in the order of the meshes.
pub(crate) fn surfaces(parts: &Parts) -> Vec<Arc<TriangleSurface>> {
    let mut found: Vec<Arc<TriangleSurface>> = Vec::new();
    for surface in parts.meshes.iter().filter_map(|mesh| mesh.surface.as_ref()) {
        if !found.iter().any(|known| Arc::ptr_eq(known, surface)) {
            found.push(Arc::clone(surface));
        }
    }
    found
}

/// The triangles of a file (STL, OBJ, MSH) in its own coordinates.
///
/// # Errors
/// The reason why there are none.
pub fn surface_of(file: &str, read: &mut ReadMesh<'_>) -> Result<TriangleSurface, String> {
    let extension = file.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let surface = match extension.as_str() {
        "stl" => stl(&read(file)?),
        "obj" => obj(&read(file)?),
        "msh" => msh(&read(file)?),
        _ => return Err("expected a mesh in STL, OBJ or MSH".to_owned()),
    }?;
    let corners = surface.vertices.len();
    if surface.triangles.is_empty() {
        return Err("holds no triangle".to_owned());
    }
    if surface.vertices.iter().flatten().any(|x| !x.is_finite())
        || surface.triangles.iter().flatten().any(|k| *k as usize >= corners)
    {
        return Err("holds a corner that is not finite or does not exist".to_owned());
    }
    Ok(surface)
}

fn stl(bytes: &[u8]) -> Result<TriangleSurface, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| format!("is no STL: {error}"))?;
    let index = |k: usize| u32::try_from(k).unwrap_or(u32::MAX);
    Ok(TriangleSurface {
        vertices: mesh.vertices.iter().map(|corner| corner.0).collect(),
        triangles: mesh.faces.iter().map(|face| face.vertices.map(index)).collect(),
    })
}

/// MuJoCo's own format: numbers of corners, normals, texture coordinates and triangles, then these, 32 bits
/// each.
fn msh(bytes: &[u8]) -> Result<TriangleSurface, String> {
    let (words, rest) = bytes.as_chunks::<4>();
    let count = |k: usize| words.get(k).and_then(|word| usize::try_from(i32::from_le_bytes(*word)).ok());
    let counts: Option<Vec<usize>> = (0..4).map(count).collect();
    let Some(&[corners, normals, texture, faces]) = counts.as_deref() else {
        return Err("is no MSH: its counts are missing or negative".to_owned());
    };
    let length = [3 * corners, 3 * normals, 2 * texture, 3 * faces].iter().sum::<usize>();
    if !rest.is_empty() || words.len() != 4 + length {
        return Err(format!(
            "is no MSH: it has {} bytes, expected {} by its counts",
            bytes.len(),
            4 * (4 + length)
        ));
    }
    let (vertices, after) = words[4..].split_at(3 * corners);
    let (_, triangles) = after.split_at(3 * normals + 2 * texture);
    // A negative index is beyond the last corner, which is refused.
    Ok(TriangleSurface {
        vertices: vertices.as_chunks::<3>().0.iter().map(|v| v.map(f32::from_le_bytes)).collect(),
        triangles: triangles.as_chunks::<3>().0.iter().map(|t| t.map(u32::from_le_bytes)).collect(),
    })
}

fn obj(bytes: &[u8]) -> Result<TriangleSurface, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    // Colours are not drawn.
    let colours = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, colours)
        .map_err(|error| format!("is no OBJ: {error}"))?;
    let mut surface = TriangleSurface::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for model in models {
        // Parts repeat the corners that they share.
        let corners = model.mesh.positions.chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]);
        let places: Vec<u32> = corners
            .map(|corner| {
                *known.entry(corner.map(f32::to_bits)).or_insert_with(|| {
                    surface.vertices.push(corner);
                    surface.vertices.len() as u32 - 1
                })
            })
            .collect();
        let place = |k: u32| places.get(k as usize).copied().unwrap_or(u32::MAX);
        surface
            .triangles
            .extend(model.mesh.indices.chunks_exact(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]));
    }
    Ok(surface)
}

/// In the frame of the shape, m.
fn placed(mut surface: TriangleSurface, mesh: &MeshGeom) -> TriangleSurface {
    let [w, x, y, z] = mesh.reference_orientation;
    for corner in &mut surface.vertices {
        let v: [f64; 3] = std::array::from_fn(|k| f64::from(corner[k]) - mesh.reference_position[k]);
        let turned = turned([w, -x, -y, -z], v);
        *corner = std::array::from_fn(|k| (mesh.scale[k] * turned[k]) as f32);
    }
    if mesh.scale.iter().product::<f64>() < 0.0 {
        surface.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    surface
}

/// A vector, turned by a unit quaternion.
pub(crate) fn turned([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let t = cross([x, y, z], v).map(|c| 2.0 * c);
    let u = cross([x, y, z], t);
    std::array::from_fn(|k| v[k] + w * t[k] + u[k])
}
