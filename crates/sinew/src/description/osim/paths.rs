//! Muscles, and springs along a path; warns of all other forces.

use super::function::Function;
use super::model::{Model, child, objects, place_on, still};
use super::wraps::Around;
use crate::body::{Actuator, ActuatorKind, PathElement, Site, Tendon, TendonPath};
use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use crate::description::mjcf::{HERE, Place};
use crate::description::orientation::IDENTITY;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

/// Why the rest of a muscle is not read.
const CABLE: &str = "of a muscle the path and `max_isometric_force` are read: it is a cable here, without \
    fibres, tendon and activation";

/// Reads all forces; what paths wrap around is placed when all points are known.
pub(super) fn read<'a>(model: &mut Model<'a>) -> Result<Vec<Around<'a>>, DescriptionError> {
    let mut arounds = Vec::new();
    for force in objects(model.tree, model.element, "ForceSet") {
        let kind = model.tree.elements[force.element].name.as_str();
        if !force.flag("appliesForce", true)? {
            let what = "a force with `appliesForce` false acts on nothing, it is left out";
            model.left_out(force.element, "appliesForce", what, false);
            continue;
        }
        let pulls = kind.contains("Muscle") || kind == "PathActuator";
        match child(model.tree, force.element, "GeometryPath") {
            Some(path) if pulls => {
                let tendon = tendon(model, force, path, &mut arounds)?;
                muscle(model, force, tendon)?;
            }
            Some(path) if kind == "PathSpring" => spring(model, force, path)?,
            None if pulls => {
                return Err(force.error("", "has no <GeometryPath>, and other paths are not read"));
            }
            _ => other(model, force, kind),
        }
    }
    Ok(arounds)
}

/// Warns of a force without a path that is read.
fn other(model: &mut Model<'_>, at: Attributes<'_>, kind: &str) {
    let shown = shortened(kind);
    let contact = ["HuntCrossleyForce", "ElasticFoundationForce", "SmoothSphereHalfSpaceForce"];
    let (what, changes) = if kind.ends_with("Actuator") {
        (format!("<{shown}> acts on no tendon, it is left out"), false)
    } else if contact.contains(&kind) {
        (format!("<{shown}> is not read: nothing touches here"), false)
    } else if kind == "CoordinateLimitForce" {
        (format!("<{shown}> is not read: the range of the joint stands for it"), false)
    } else {
        (format!("<{shown}> is not read, its force is left out"), true)
    };
    model.left_out(at.element, kind, &what, changes);
}

/// The actuator of the last tendon.
fn muscle(model: &mut Model<'_>, at: Attributes<'_>, tendon: Tendon) -> Result<(), DescriptionError> {
    let key = if at.text("max_isometric_force").is_some() { "max_isometric_force" } else { "optimal_force" };
    at.required(key)?;
    let force = at.not_negative(key)?;
    if key == "max_isometric_force" {
        model.left_out(at.element, "muscle", CABLE, false);
    }
    let (index, name) = (model.parts.tendons.len(), tendon.name.clone());
    model.describe("tendon", index, at.element);
    model.describe("actuator", model.parts.actuators.len(), at.element);
    model.parts.tendons.push(tendon);
    // A cable pulls with a negative force, as in MJCF.
    model.parts.actuators.push(Actuator {
        name,
        kind: ActuatorKind::Motor,
        tendon: index,
        gear: 1.0,
        control_range: Some([-force, 0.0]),
        force_range: None,
        law: BTreeMap::new(),
    });
    Ok(())
}

/// A spring that pulls where it is longer than at rest.
fn spring<'a>(
    model: &mut Model<'a>,
    at: Attributes<'a>,
    path: Attributes<'a>,
) -> Result<(), DescriptionError> {
    let mut arounds = Vec::new();
    let mut spring = tendon(model, at, path, &mut arounds)?;
    spring.stiffness = at.not_negative("stiffness")?;
    spring.spring_length = Some([0.0, at.not_negative("resting_length")?]);
    if at.not_negative("dissipation")? > 0.0 {
        let what = "`dissipation` of a <PathSpring> is not read, what it does is left out";
        model.left_out(at.element, "dissipation", what, true);
    }
    if !arounds.is_empty() {
        let what = "<PathWrap> of a <PathSpring> is not read: it goes straight from point to point";
        model.left_out(at.element, "wrap of a spring", what, true);
    }
    model.describe("spring", model.parts.springs.len(), at.element);
    model.parts.springs.push(spring);
    Ok(())
}

/// A path through its points; what it wraps around is placed when all points are known.
fn tendon<'a>(
    model: &mut Model<'a>,
    at: Attributes<'a>,
    path: Attributes<'a>,
    arounds: &mut Vec<Around<'a>>,
) -> Result<Tendon, DescriptionError> {
    let name = at.required("name")?;
    let mut elements = Vec::new();
    for point in objects(model.tree, path.element, "PathPointSet") {
        elements.extend(site(model, name, point)?.map(PathElement::Site));
    }
    if elements.len() < 2 {
        return Err(
            path.error("PathPointSet", format!("has {} points: expected at least two", elements.len()))
        );
    }
    for wrap in objects(model.tree, path.element, "PathWrapSet") {
        let range = wrap.array_or("range", [-1.0, -1.0])?;
        let end = |value: f64, other: usize| {
            if value < 1.0 { other } else { (value as usize - 1).min(elements.len() - 1) }
        };
        let (first, last) = (end(range[0], 0), end(range[1], elements.len() - 1));
        arounds.push(Around { at: wrap, tendon: model.parts.tendons.len(), first, last });
    }
    Ok(Tendon {
        name: name.to_string(),
        path: TendonPath::Spatial(elements),
        sheath: None,
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    })
}

/// The site of a point, unless the path never passes it; a moving one is on a body of its own.
fn site<'a>(
    model: &mut Model<'a>,
    muscle: &str,
    at: Attributes<'a>,
) -> Result<Option<usize>, DescriptionError> {
    let kind = model.tree.elements[at.element].name.as_str();
    let (mut body, frame) = model.on_body(at, "socket_parent_frame")?;
    let mut name = at.required("name")?.to_string();
    if model.parts.sites.iter().any(|site| site.name == name) {
        name = format!("{muscle}:{name}");
    }
    let mut active = None;
    let mut position = [0.0; 3];
    match kind {
        "PathPoint" => position = place_on(frame, at)?,
        "ConditionalPathPoint" => {
            position = place_on(frame, at)?;
            let (_, coordinate) =
                model.coordinate(at, "socket_coordinate", at.required("socket_coordinate")?)?;
            let range: [f64; 2] = at.array("range")?.ok_or_else(|| at.error("range", "is missing"))?;
            if let Some(joint) = coordinate.joint {
                active = Some((joint, range));
            } else if !(range[0]..=range[1]).contains(&coordinate.value) {
                return Ok(None);
            }
        }
        "MovingPathPoint" => body = moving(model, &name, at, body, frame)?,
        _ => {
            let expected = "expected a PathPoint, a ConditionalPathPoint or a MovingPathPoint";
            return Err(at.error("", format!("is a <{}>: {expected}", shortened(kind))));
        }
    }
    model.describe("site", model.parts.sites.len(), at.element);
    model.parts.sites.push(Site { name, body, position, orientation: IDENTITY, active });
    Ok(Some(model.parts.sites.len() - 1))
}

/// A body without mass at a point that moves with coordinates.
fn moving<'a>(
    model: &mut Model<'a>,
    name: &str,
    at: Attributes<'a>,
    parent: usize,
    frame: Place,
) -> Result<usize, DescriptionError> {
    let mut slides = Vec::new();
    let mut start = HERE;
    for (k, letter) in ["x", "y", "z"].into_iter().enumerate() {
        let location = child(model.tree, at.element, &format!("{letter}_location"))
            .ok_or_else(|| at.error(&format!("{letter}_location"), "is missing"))?;
        let function = Function::within(location)?;
        let constant = function.linear().filter(|[_, slope]| *slope == 0.0);
        let socket = format!("socket_{letter}_coordinate");
        let coordinate = match constant {
            Some(_) => None,
            None => Some(model.coordinate(at, &socket, at.required(&socket)?)?),
        };
        match (coordinate, constant) {
            (Some((name, coordinate)), _) if coordinate.joint.is_some() => slides.push((k, name, function)),
            (other, _) => {
                start.position[k] = function.value(other.map_or(0.0, |(_, coordinate)| coordinate.value));
            }
        }
    }
    let body = model.parts.bodies.len();
    model.parts.bodies.push(still(name, parent, frame.of(start)));
    model.describe("body", body, at.element);
    for (k, name_of, function) in slides {
        let axis = core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let letter = ["x", "y", "z"][k];
        let joint = model.add_joint(&format!("{name}:{letter}"), body, false, axis, [0.0; 3]);
        model.describe("joint", joint, at.element);
        model.follow(joint, at, name_of, function);
    }
    Ok(body)
}
