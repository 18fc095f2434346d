//! Geoms: wrapping surfaces of cables, and mass of bodies.

use super::compiler::Compiler;
use super::import_state::{Import, Surface};
use super::inertia::diagonal;
use super::mesh;
use super::mesh_asset::MeshWeight;
use super::place::{Place, place};
use super::shell;
use super::solid::{Solid, TYPES, Weight};
use crate::body::{Geom, GeomKind, WrapKind};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;
use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Reads a geom, records it if a cable can wrap around it, and returns its contribution to the mass.
pub(super) fn read(
    import: &mut Import<'_>,
    at: Attributes<'_>,
    body: usize,
    frame: Place,
) -> Result<Weight, DescriptionError> {
    let kind = at.word("type", &TYPES)?.unwrap_or(if at.text("mesh").is_some() { 7 } else { 0 });
    let mass = at.number("mass")?;
    let density = at.number_or("density", 1000.0)?;
    if mass.unwrap_or(density) < 0.0 {
        return Err(
            at.error(if mass.is_some() { "mass" } else { "density" }, "is negative: expected a number >= 0")
        );
    }
    let group = at.number_or("group", 0.0)?;
    let counts = group >= import.compiler.inertia_groups[0] && group <= import.compiler.inertia_groups[1];
    let heavy = counts && mass.unwrap_or(density) > 0.0;
    if kind >= 7 || at.text("mesh").is_some() {
        import.name("geom", at)?;
        if at.text("mesh").is_some() {
            let place = frame.of(place(at, &import.compiler)?);
            mesh::shape(import, at, body, place, group)?;
            if let Some(mesh) = MeshWeight::new(at, place, mass, density).filter(|_| heavy && kind == 7) {
                return Ok(Weight::Mesh(mesh));
            }
        } else {
            let kind = TYPES[kind];
            import.pass_over(at.element, kind, &format!("<geom> of type {kind}: its shape is not drawn"));
        }
        return Ok(if heavy { Weight::Unknown } else { Weight::Nothing });
    }
    let name = import.name("geom", at)?;
    let (inner, size) = shape(at, kind, &import.compiler)?;
    let place = frame.of(inner);
    let shown = GeomKind::from_word(TYPES[kind]).map(|kind| {
        let Place { position, orientation } = place;
        let size = core::array::from_fn(|i| if i < kind.sizes() { size[i] } else { 0.0 });
        import.parts.geoms.push(Geom { body, kind, size, position, orientation });
        import.geom_groups.push(group);
        import.parts.geoms.len() - 1
    });
    if let Some(name) = name {
        let wrap = match kind {
            0 => Some(WrapKind::Sphere),
            2 => Some(WrapKind::Cylinder),
            _ => None,
        };
        let element = &at.tree.elements[at.element];
        let at = (at.tree.files[element.file].clone(), element.line);
        import
            .surfaces
            .insert(name, Surface { body, kind: wrap, radius: size[0], place, at, geom: shown, wrap: None });
    }
    if kind >= 5 || !counts {
        return Ok(Weight::Nothing);
    }
    let hollow = at.flag("shellinertia", false)?;
    let (volume, per_mass) = if hollow { shell::inertia(kind, size) } else { unit_inertia(kind, size) };
    let mass = mass.unwrap_or(density * volume);
    let inertia = per_mass.map(|x| x * mass);
    if mass <= turn::SHORTEST {
        return Ok(Weight::Nothing);
    }
    if !mass.is_finite() || diagonal(inertia).iter().any(|x| !x.is_finite()) {
        return Err(at.error("size", "gives a mass or inertia that is not finite"));
    }
    Ok(Weight::Solid(Solid { mass, position: place.position, orientation: place.orientation, inertia }))
}

/// Number of sizes of each type, and with `fromto`.
const SIZES: [(usize, usize); 7] = [(1, 1), (2, 1), (2, 1), (3, 1), (3, 1), (0, 0), (0, 0)];

/// Pose and sizes; `fromto` sets the pose and the half-length along z.
fn shape(
    at: Attributes<'_>,
    kind: usize,
    compiler: &Compiler,
) -> Result<(Place, [f64; 3]), DescriptionError> {
    let mut size = [0.0; 3];
    // A short list is completed from the class.
    let inherited = at.given.and_then(|given| given.get("size"));
    let words = inherited.into_iter().flat_map(|text| text.split_ascii_whitespace());
    let inherited: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
    let own = at.list("size", 1, 3)?.unwrap_or_default();
    for (i, size) in size.iter_mut().enumerate() {
        *size = own.get(i).or(inherited.get(i)).copied().unwrap_or(0.0);
    }
    let (needed, needed_with_ends) = SIZES[kind.min(6)];
    let ends = if matches!(kind, 1..=4) { at.array::<6>("fromto")? } else { None };
    let needed = if ends.is_some() { needed_with_ends } else { needed };
    if let Some(i) = (0..needed).find(|&i| !(size[i] > 0.0 && size[i].is_finite())) {
        return Err(at.error(
            "size",
            format!("number {} is {}: expected a number > 0 for a {}", i + 1, size[i], TYPES[kind]),
        ));
    }
    let Some([a, b, c, d, e, f]) = ends else {
        return Ok((place(at, compiler)?, size));
    };
    let along = [a - d, b - e, c - f];
    let length = libm::sqrt(turn::dot(along, along));
    let Some(axis) = turn::unit(along) else {
        return Err(at.error("fromto", "has both ends in one point: expected a length > 0"));
    };
    match kind {
        1 | 2 => size[1] = length / 2.0,
        // Boxes and ellipsoids given by `fromto` have equal width and thickness.
        _ => size = [size[0], size[0], length / 2.0],
    }
    let position = [(a + d) / 2.0, (b + e) / 2.0, (c + f) / 2.0];
    Ok((Place { position, orientation: turn::z_to(axis) }, size))
}

/// Volume, and principal moments of a solid of mass one.
fn unit_inertia(kind: usize, s: [f64; 3]) -> (f64, [f64; 3]) {
    let squares = |a: f64, b: f64| a * a + b * b;
    match kind {
        0 => (4.0 / 3.0 * PI * s[0] * s[0] * s[0], [0.4 * s[0] * s[0]; 3]),
        1 => {
            let (r, h) = (s[0], 2.0 * s[1]);
            let balls = 4.0 * r / (4.0 * r + 3.0 * h);
            let rod = 1.0 - balls;
            let ball = balls * 0.4 * r * r;
            let across = rod * (3.0 * r * r + h * h) / 12.0 + ball + balls * h * (3.0 * r + 2.0 * h) / 8.0;
            (PI * (r * r * h + 4.0 / 3.0 * r * r * r), [across, across, rod * r * r / 2.0 + ball])
        }
        2 => {
            let (r, h) = (s[0], 2.0 * s[1]);
            let across = (3.0 * r * r + h * h) / 12.0;
            (PI * r * r * h, [across, across, r * r / 2.0])
        }
        3 => (
            4.0 / 3.0 * PI * s[0] * s[1] * s[2],
            [squares(s[1], s[2]) / 5.0, squares(s[0], s[2]) / 5.0, squares(s[0], s[1]) / 5.0],
        ),
        _ => (
            8.0 * s[0] * s[1] * s[2],
            [squares(s[1], s[2]) / 3.0, squares(s[0], s[2]) / 3.0, squares(s[0], s[1]) / 3.0],
        ),
    }
}
