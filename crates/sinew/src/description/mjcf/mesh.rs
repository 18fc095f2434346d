//! Meshes: the files of shapes, for drawings and for mass.

use super::compiler::Compiler;
use super::import_state::Import;
use super::inertia::Inertia;
use super::mesh_asset::{MeshAsset, MeshWeight};
use super::mesh_mass::{LAWS, MeshLaw, MeshMass, Triangles, WORDS};
use super::place::Place;
use crate::body::MeshGeom;
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::mesh_file::joined;
use crate::description::orientation as turn;
use alloc::format;
use alloc::string::{String, ToString};

/// Mass, centre of mass and inertia of a geom with a mesh in its body.
pub(super) fn inertia_of(import: &mut Import<'_>, geom: &MeshWeight) -> Result<Inertia, DescriptionError> {
    let MeshMass { volume, center, tensor } = mass_of(import, geom)?;
    let density = geom.mass.map_or(geom.density, |mass| mass / volume);
    Ok(Inertia {
        mass: density * volume,
        center: geom.place.point(center),
        tensor: turn::turn_tensor(geom.place.orientation, tensor.map(|x| density * x)),
    })
}

/// Reads a `<mesh>` of `<asset>`.
pub(super) fn read(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = import.attributes(element, None)?;
    let quaternion = at.array_or("refquat", turn::IDENTITY)?;
    let scale = at.array_or("scale", [1.0; 3])?;
    let reference_position = at.array_or("refpos", [0.0; 3])?;
    let reference_orientation = turn::unit(quaternion)
        .ok_or_else(|| at.error("refquat", "has no direction: expected a vector that is not zero"))?;
    // Its body and its place there are those of the geoms that show it.
    let shape = MeshGeom {
        body: 0,
        file: at.text("file").map(|file| path(&import.compiler, file)).unwrap_or_default(),
        scale,
        reference_position,
        reference_orientation,
        position: [0.0; 3],
        orientation: turn::IDENTITY,
        surface: None,
    };
    let law = at.word("inertia", &WORDS)?.map_or(MeshLaw::Legacy, |word| LAWS[word]);
    let within = triangles(at)?;
    let name = import.name("mesh", at)?.or_else(|| at.text("file").map(stem));
    if let Some(name) = name {
        import.meshes.insert(name, MeshAsset { element, shape, within, law, mass: None });
    }
    Ok(())
}

/// Triangles in the attributes of a mesh.
fn triangles(at: Attributes<'_>) -> Result<Option<Triangles>, DescriptionError> {
    let corners = at.list("vertex", 12, usize::MAX)?;
    let faces = at.list("face", 3, usize::MAX)?;
    let Some(corners) = corners else { return Ok(None) };
    let (corners, left) = corners.as_chunks::<3>();
    let (faces, left_of_faces) = faces.as_deref().unwrap_or_default().as_chunks::<3>();
    for (name, left) in [("vertex", left), ("face", left_of_faces)] {
        if !left.is_empty() {
            return Err(at.error(name, "has a length that is no multiple of three"));
        }
    }
    // In single precision, as MuJoCo keeps them.
    let corners = corners.iter().map(|corner| corner.map(|x| f64::from(x as f32))).collect();
    let faces = faces.iter().map(|face| face.map(|k| k as usize)).collect();
    let mut found = Triangles { corners, faces };
    if found.faces.is_empty() {
        found = found.hull().map_err(|problem| at.error("vertex", problem))?;
    }
    found.check().map_err(|problem| at.error("face", problem))?;
    Ok(Some(found))
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
    let Some(asset) = asset.filter(|asset| !asset.shape.file.is_empty()).cloned() else {
        import.pass_over(at.element, "mesh", "<geom> with a mesh that no file holds: its shape is not drawn");
        return Ok(());
    };
    import.parts.meshes.push(MeshGeom {
        body,
        position: place.position,
        orientation: place.orientation,
        ..asset.shape
    });
    import.mesh_groups.push(group);
    Ok(())
}

/// The mass of the mesh of a geom, in the mesh's frame.
fn mass_of(import: &mut Import<'_>, geom: &MeshWeight) -> Result<MeshMass, DescriptionError> {
    let tree = import.tree;
    let Some(asset) = import.meshes.get(&geom.mesh) else {
        let problem = format!("is `{}`, but there is no mesh of that name", geom.mesh);
        return Err(tree.error(geom.element, "mesh", problem));
    };
    if let Some(mass) = asset.mass {
        return Ok(mass);
    }
    let (element, law, shape) = (asset.element, asset.law, asset.shape.clone());
    let refused = |problem: String| {
        let way = "an <inertial> in the body, or mass=\"0\" in the geom";
        tree.error(element, "", format!("has no mass: {problem}; otherwise {way}"))
    };
    let mut triangles = match (&asset.within, shape.file.as_str()) {
        (Some(triangles), _) => triangles.clone(),
        (None, "") => return Err(refused("expected a file, or vertices".to_string())),
        (None, file) => {
            let text = (import.files)(file).and_then(|text| Triangles::parse(&text));
            text.map_err(|problem| refused(format!("`{file}`: {problem}")))?
        }
    };
    place(&mut triangles, &shape);
    let mass = triangles.mass(law).map_err(refused)?;
    if let Some(asset) = import.meshes.get_mut(&geom.mesh) {
        asset.mass = Some(mass);
    }
    Ok(mass)
}

/// From the coordinates of a file to the frame of the shape, m.
fn place(triangles: &mut Triangles, shape: &MeshGeom) {
    let [w, x, y, z] = shape.reference_orientation;
    for corner in &mut triangles.corners {
        let from = core::array::from_fn(|i| corner[i] - shape.reference_position[i]);
        let turned = turn::rotate([w, -x, -y, -z], from);
        *corner = core::array::from_fn(|i| shape.scale[i] * turned[i]);
    }
    if shape.scale.iter().product::<f64>() < 0.0 {
        triangles.faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
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
