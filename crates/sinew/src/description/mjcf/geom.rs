//! Places and solids: where a thing stands in its body, and what mass it carries.

use super::compiler::Compiler;
use super::import::{Import, Surface};
use super::inertia::diagonal;
use super::shell;
use crate::body::WrapKind;
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;
use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// A frame in another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) position: [f64; 3],
    pub(super) orientation: [f64; 4],
}

pub(super) const HERE: Place = Place { position: [0.0; 3], orientation: turn::IDENTITY };

impl Place {
    /// A point of this frame in the outer one.
    pub(super) fn point(&self, local: [f64; 3]) -> [f64; 3] {
        let turned = turn::rotate(self.orientation, local);
        core::array::from_fn(|i| self.position[i] + turned[i])
    }

    /// A frame within this one, in the outer one.
    pub(super) fn of(&self, inner: Place) -> Place {
        let orientation = if turn::is_identity(self.orientation) {
            inner.orientation
        } else {
            turn::product(self.orientation, inner.orientation)
        };
        Place { position: self.point(inner.position), orientation }
    }
}

/// `pos` and whichever orientation is given.
pub(super) fn place(at: Attributes<'_>, compiler: &Compiler) -> Result<Place, DescriptionError> {
    Ok(Place { position: at.array_or("pos", [0.0; 3])?, orientation: orientation(at, compiler)? })
}

const FORMS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

fn orientation(at: Attributes<'_>, compiler: &Compiler) -> Result<[f64; 4], DescriptionError> {
    let own = Attributes::own(at.tree, at.element);
    let count = FORMS.iter().filter(|form| own.text(form).is_some()).count();
    if count > 1 {
        return Err(at.error(
            "",
            "gives its orientation more than once: expected one of quat, axisangle, xyaxes, zaxis, euler",
        ));
    }
    // An own form replaces whichever form the class has.
    let at = if count == 1 { own } else { at };
    let short = |form: &str| at.error(form, "has no direction: expected a vector that is not zero");
    if let Some(quat) = at.array::<4>("quat")? {
        return turn::unit(quat).ok_or_else(|| short("quat"));
    }
    if let Some([x, y, z, angle]) = at.array::<4>("axisangle")? {
        let axis = turn::unit([x, y, z]).ok_or_else(|| short("axisangle"))?;
        return Ok(turn::about(axis, angle * compiler.radians));
    }
    if let Some([a, b, c, d, e, f]) = at.array::<6>("xyaxes")? {
        let x = turn::unit([a, b, c]).ok_or_else(|| short("xyaxes"))?;
        let along = turn::dot(x, [d, e, f]);
        let y = core::array::from_fn(|i| [d, e, f][i] - along * x[i]);
        let y = turn::unit(y).ok_or_else(|| short("xyaxes"))?;
        let z = turn::unit(turn::cross(x, y)).ok_or_else(|| short("xyaxes"))?;
        return Ok(turn::from_axes(x, y, z));
    }
    if let Some(axis) = at.array::<3>("zaxis")? {
        return turn::unit(axis).map(turn::z_to).ok_or_else(|| short("zaxis"));
    }
    if let Some(angles) = at.array::<3>("euler")? {
        return Ok(turn::euler(angles.map(|a| a * compiler.radians), compiler.sequence));
    }
    Ok(turn::IDENTITY)
}

/// A massive solid in its body: principal moments about its own axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    pub(super) mass: f64,
    pub(super) position: [f64; 3],
    pub(super) orientation: [f64; 4],
    pub(super) inertia: [f64; 3],
}

/// What a geom contributes to its body's mass.
pub(super) enum Weight {
    Nothing,
    Solid(Solid),
    /// Something whose inertia only the mesh file knows.
    Unknown,
}

pub(super) const TYPES: [&str; 9] =
    ["sphere", "capsule", "cylinder", "ellipsoid", "box", "plane", "hfield", "mesh", "sdf"];

/// Reads a geom, remembers it if a cable could wrap around it, and hands back its weight.
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
        import.pass_over(
            at.element,
            "mesh",
            "<geom> with a mesh: meshes are not read, its shape is left out",
        );
        return Ok(if heavy { Weight::Unknown } else { Weight::Nothing });
    }
    let name = import.name("geom", at)?;
    let (inner, size) = shape(at, kind, &import.compiler)?;
    let place = frame.of(inner);
    if let Some(name) = name {
        let wrap = match kind {
            0 => Some(WrapKind::Sphere),
            2 => Some(WrapKind::Cylinder),
            _ => None,
        };
        let element = &at.tree.elements[at.element];
        let at = (at.tree.files[element.file].clone(), element.line);
        import.surfaces.insert(name, Surface { body, kind: wrap, radius: size[0], place, at, wrap: None });
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

/// How many sizes each type has, and how many when `fromto` gives the length.
const SIZES: [(usize, usize); 7] = [(1, 1), (2, 1), (2, 1), (3, 1), (3, 1), (0, 0), (0, 0)];

/// Place and sizes; `fromto` sets the place and the half-length along z.
fn shape(
    at: Attributes<'_>,
    kind: usize,
    compiler: &Compiler,
) -> Result<(Place, [f64; 3]), DescriptionError> {
    let mut size = [0.0; 3];
    // A short list leaves the rest to the class.
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
        // Boxes and ellipsoids between two ends are as wide as they are thick.
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
