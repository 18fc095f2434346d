//! The tree of bodies: joints, inertias, sites and geoms, in MuJoCo's order.

use super::attach::attach;
use super::compiler::InertiaFrom;
use super::geom;
use super::import_state::Import;
use super::inertia::{self, Inertia};
use super::mesh;
use super::mesh_asset::MeshWeight;
use super::place::{HERE, Place, place};
use super::ranges::{limits, linear};
use super::solid::Weight;
use crate::body::{Body, Joint, JointKind, Site};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

/// An element within a body, with the frames around it composed.
#[derive(Clone, Copy)]
struct Seen<'a> {
    element: usize,
    frame: Place,
    class: Option<&'a str>,
}

/// Reads `worldbody` and its subtree.
pub(super) fn world(import: &mut Import<'_>) -> Result<(), DescriptionError> {
    import.parts.bodies.push(Body {
        name: "world".to_string(),
        parent: 0,
        position: [0.0; 3],
        orientation: turn::IDENTITY,
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
        gravity_compensation: 0.0,
    });
    let tree = import.tree;
    let worlds = tree.elements[0].children.iter().copied().filter(|&e| tree.elements[e].name == "worldbody");
    let mut open: Vec<(Seen<'_>, usize)> = Vec::new();
    let mut first = Vec::new();
    for world in worlds {
        first.extend(contents(import, world, 0, None)?);
    }
    open.extend(first.into_iter().rev().map(|seen| (seen, 0)));
    while let Some((seen, parent)) = open.pop() {
        if tree.elements[seen.element].name == "attach" {
            attach(import, seen.element, seen.frame, parent)?;
            continue;
        }
        let index = body(import, seen, parent)?;
        let class = tree.elements[seen.element].attribute("childclass").or(seen.class);
        let inner = contents(import, seen.element, index, class)?;
        open.extend(inner.into_iter().rev().map(|seen| (seen, index)));
    }
    total_mass(import);
    Ok(())
}

fn total_mass(import: &mut Import<'_>) {
    let Some(desired) = import.compiler.total_mass else { return };
    let sum: f64 = import.parts.bodies.iter().map(|body| body.mass).sum();
    if sum > 0.0 {
        let scale = desired / sum;
        for body in &mut import.parts.bodies {
            body.mass *= scale;
            body.inertia = body.inertia.map(|x| x * scale);
        }
    }
}

/// Reads a body's own pose; its content is read later.
fn body(import: &mut Import<'_>, seen: Seen<'_>, parent: usize) -> Result<usize, DescriptionError> {
    let at = Attributes::own(import.tree, seen.element);
    if let Some(class) = at.text("childclass") {
        import.defaults.class(import.tree, seen.element, "childclass", class)?;
    }
    if at.flag("mocap", false)? {
        import.pass_over(seen.element, "mocap", "`mocap` is not read: the body stands where it is described");
    }
    let index = import.parts.bodies.len();
    if at.text("name") == Some("world") {
        return Err(at.error("name", "is `world`, which is the name of the world"));
    }
    let name = import.name_as("body", at, index)?.unwrap_or_default();
    let place = seen.frame.of(place(at, &import.compiler)?);
    import.parts.bodies.push(Body {
        name,
        parent,
        position: place.position,
        orientation: place.orientation,
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
        gravity_compensation: at.number_or("gravcomp", 0.0)?,
    });
    Ok(index)
}

/// Reads the direct content of a body, with frames resolved; returns its child bodies.
fn contents<'a>(
    import: &mut Import<'a>,
    element: usize,
    body: usize,
    class: Option<&'a str>,
) -> Result<Vec<Seen<'a>>, DescriptionError> {
    let tree = import.tree;
    let mut bodies = Vec::new();
    let (mut solids, mut meshes, mut unknown, mut inertial) = (Vec::new(), Vec::new(), None, None);
    let within = |element: usize, frame: Place, class| {
        tree.elements[element].children.iter().rev().map(move |&element| Seen { element, frame, class })
    };
    let mut open: Vec<Seen<'a>> = within(element, HERE, class).collect();
    while let Some(seen) = open.pop() {
        let Seen { element, frame, class } = seen;
        match tree.elements[element].name.as_str() {
            "body" | "attach" => bodies.push(seen),
            "frame" => {
                let at = Attributes::own(tree, element);
                if let Some(class) = at.text("childclass") {
                    import.defaults.class(tree, element, "childclass", class)?;
                }
                let frame = frame.of(place(at, &import.compiler)?);
                open.extend(within(element, frame, at.text("childclass").or(class)));
            }
            "joint" | "freejoint" => joint(import, seen, body)?,
            "site" => site(import, seen, body)?,
            "geom" => {
                let at = import.attributes(element, class)?;
                match geom::read(import, at, body, frame)? {
                    Weight::Solid(solid) => solids.push(Inertia::from(&solid)),
                    Weight::Mesh(mesh) => meshes.push(mesh),
                    Weight::Unknown => unknown = unknown.or(Some(element)),
                    Weight::Nothing => {}
                }
            }
            "inertial" if body > 0 && inertial.is_none() => inertial = Some(element),
            "inertial" => {
                return Err(tree.error(element, "", "is one too many: the world has none, a body one"));
            }
            "camera" | "light" => {}
            name @ ("plugin" | "composite" | "flexcomp") => {
                import.without(element, name, &format!("<{name}> is not read, what it makes is left out"));
            }
            _ => return Err(tree.error(element, "", "is not read within a body")),
        }
    }
    if body > 0 {
        weigh(import, body, element, &Weights { solids, meshes, unknown }, inertial)?;
    }
    Ok(bodies)
}

/// The geoms of a body that have mass.
struct Weights {
    solids: Vec<Inertia>,
    meshes: Vec<MeshWeight>,
    /// The first whose mass is not computed.
    unknown: Option<usize>,
}

impl Weights {
    /// The sum; of what does not move without meshes, which change nothing there.
    fn total(
        &self,
        import: &mut Import<'_>,
        body: usize,
        element: usize,
    ) -> Result<(Inertia, usize), DescriptionError> {
        let first = self.unknown.or(self.meshes.first().map(|mesh| mesh.element));
        if let Some(mesh) = first.filter(|_| !moves(import, body) && import.compiler.total_mass.is_none()) {
            let what = "a mesh in a body that does not move is left out of its mass, which changes no motion";
            import.pass_over(mesh, "mesh of the world", what);
            return Ok((inertia::total(&self.solids), element));
        }
        if let Some(geom) = self.unknown {
            let problem = "carries the inertia of a solid that is fitted to a mesh, which \
                is not computed: expected an <inertial> in its body, or mass=\"0\" here";
            return Err(import.tree.error(geom, "", problem));
        }
        let mut parts = self.solids.clone();
        for mesh in &self.meshes {
            parts.push(mesh::inertia_of(import, mesh)?);
        }
        Ok((inertia::total(&parts), element))
    }
}

/// Mass and inertia, from the source that the settings select.
fn weigh(
    import: &mut Import<'_>,
    body: usize,
    element: usize,
    geoms: &Weights,
    inertial: Option<usize>,
) -> Result<(), DescriptionError> {
    let heavy = !geoms.solids.is_empty() || !geoms.meshes.is_empty() || geoms.unknown.is_some();
    let from_geoms = match import.compiler.inertia_from {
        InertiaFrom::Inertial => false,
        InertiaFrom::Auto => inertial.is_none(),
        InertiaFrom::Geoms => inertial.is_none() || heavy,
    };
    let (given, at) = match inertial {
        Some(at) if !from_geoms => (explicit(import, at)?, at),
        _ if from_geoms => geoms.total(import, body, element)?,
        _ => (inertia::NOTHING, element),
    };
    let Inertia { mass, mut center, tensor } = bounded(import, at, given)?;
    if mass > 0.0 && given.mass == 0.0 && at == element {
        // MuJoCo's rule for a body whose mass comes from `boundmass` alone.
        center = import.parts.bodies[body].position;
    }
    let body = &mut import.parts.bodies[body];
    (body.mass, body.center_of_mass, body.inertia) = (mass, center, tensor);
    Ok(())
}

/// Whether a joint lies between a body and the world.
fn moves(import: &Import<'_>, mut body: usize) -> bool {
    while body != 0 {
        if import.parts.joints.iter().any(|joint| joint.body == body) {
            return true;
        }
        body = import.parts.bodies[body].parent;
    }
    false
}

fn explicit(import: &Import<'_>, element: usize) -> Result<Inertia, DescriptionError> {
    let at = Attributes::own(import.tree, element);
    at.required("mass")?;
    let mass = at.not_negative("mass")?;
    let full = at.array::<6>("fullinertia")?;
    let diagonal = at.array::<3>("diaginertia")?;
    let place = place(at, &import.compiler)?;
    let tensor = match (full, diagonal) {
        (Some(_), Some(_)) => {
            return Err(at.error("fullinertia", "stands beside `diaginertia`: expected one of them"));
        }
        (Some(full), None) if turn::is_identity(place.orientation) => full,
        (Some(_), None) => return Err(at.error("fullinertia", "stands beside an orientation: expected none")),
        (None, diagonal) => {
            turn::turn_tensor(place.orientation, inertia::diagonal(diagonal.unwrap_or_default()))
        }
    };
    Ok(Inertia { mass, center: place.position, tensor })
}

/// Applies lower bounds and balancing, and refuses impossible inertia.
fn bounded(import: &Import<'_>, at: usize, given: Inertia) -> Result<Inertia, DescriptionError> {
    let compiler = &import.compiler;
    let mut inertia = given;
    inertia.mass = inertia.mass.max(compiler.min_mass);
    let (moments, axes) = inertia::principal(given.tensor);
    let least = compiler.min_inertia;
    let mut desired = moments.map(|x| if least > 0.0 { x.max(least) } else { x });
    let sum: f64 = desired.iter().sum();
    if compiler.balance && desired.iter().any(|x| 2.0 * x > sum) {
        desired = [sum / 3.0; 3];
    }
    // Values within the bounds keep their bits.
    let tolerance = 1e-15 * sum.abs();
    if moments.iter().zip(desired).any(|(have, want)| (have - want).abs() > tolerance) {
        inertia.tensor = inertia::compose(desired, axes);
    }
    inertia::possible(inertia.tensor).map_err(|problem| import.tree.error(at, "", problem))?;
    Ok(inertia)
}

fn site(import: &mut Import<'_>, seen: Seen<'_>, body: usize) -> Result<(), DescriptionError> {
    let at = import.attributes(seen.element, seen.class)?;
    let name = import.name_as("site", at, import.parts.sites.len())?.unwrap_or_default();
    let mut inner = place(at, &import.compiler)?;
    if let Some([a, b, c, d, e, f]) = at.array::<6>("fromto")? {
        inner.position = [(a + d) / 2.0, (b + e) / 2.0, (c + f) / 2.0];
        let axis = turn::unit([a - d, b - e, c - f]);
        inner.orientation = turn::z_to(axis.ok_or_else(|| at.error("fromto", "has both ends in one point"))?);
    }
    let place = seen.frame.of(inner);
    import.parts.sites.push(Site {
        name,
        body,
        position: place.position,
        orientation: place.orientation,
        active: None,
    });
    Ok(())
}

const KINDS: [JointKind; 4] = [JointKind::Hinge, JointKind::Slide, JointKind::Ball, JointKind::Free];

fn joint(import: &mut Import<'_>, seen: Seen<'_>, body: usize) -> Result<(), DescriptionError> {
    let free = import.tree.elements[seen.element].name == "freejoint";
    let at = if free {
        Attributes::own(import.tree, seen.element)
    } else {
        import.attributes(seen.element, seen.class)?
    };
    if body == 0 {
        return Err(at.error("", "stands in the world, which does not move: expected a body"));
    }
    import.ignored(at, &["springyield"]);
    if let Some([time, ratio]) =
        at.array("springdamper")?.filter(|[time, ratio]| *time != 0.0 || *ratio != 0.0)
    {
        if time <= 0.0 || ratio <= 0.0 {
            return Err(at.error("springdamper", format!("is `{time} {ratio}`: expected two numbers > 0")));
        }
        if import.depth > 0 {
            import.ignored(at, &["springdamper"]);
        }
        import.spring_dampers.push((import.parts.joints.len(), [time, ratio]));
    }
    let aligned = at.word("align", &["false", "true", "auto"])?;
    if free && (aligned == Some(1) || aligned != Some(0) && import.compiler.align_free) {
        return Err(at.error(
            "align",
            "moves the frame of the body to the principal axes of its inertia, which is not done here: expected \
                false, and no alignfree in <compiler>",
        ));
    }
    let kind = match at.word("type", &["hinge", "slide", "ball", "free"])? {
        Some(place) if !free => KINDS[place],
        _ if free => JointKind::Free,
        _ => JointKind::Hinge,
    };
    if kind == JointKind::Free && import.parts.bodies[body].parent != 0 {
        return Err(at.error("", "is free within another body: expected it in a body of the world"));
    }
    let name = import.name_as("joint", at, import.parts.joints.len())?.unwrap_or_default();
    let axis = turn::unit(at.array_or("axis", [0.0, 0.0, 1.0])?)
        .ok_or_else(|| at.error("axis", "is zero: expected a direction"))?;
    let unit = if kind == JointKind::Slide { 1.0 } else { import.compiler.radians };
    let only = kind == JointKind::Hinge || kind == JointKind::Slide;
    let range = if kind == JointKind::Free {
        None
    } else {
        limits(at, import.compiler.auto_limits, "limited", "range")?
    };
    let (damping, stiffness) = (linear(import, at, "damping")?, linear(import, at, "stiffness")?);
    let joint = Joint {
        name,
        body,
        kind,
        anchor: if kind == JointKind::Free {
            [0.0; 3]
        } else {
            seen.frame.point(at.array_or("pos", [0.0; 3])?)
        },
        axis: if only { turn::rotate(seen.frame.orientation, axis) } else { [0.0, 0.0, 1.0] },
        reference: if only { at.number_or("ref", 0.0)? * unit } else { 0.0 },
        range: range.map(|range| range.map(|x| x * unit)),
        armature: at.not_negative("armature")?,
        damping,
        friction: at.not_negative("frictionloss")?,
        stiffness,
        spring_reference: if only { at.number_or("springref", 0.0)? * unit } else { 0.0 },
        flex: 0.0,
    };
    import.parts.joints.push(joint);
    Ok(())
}
