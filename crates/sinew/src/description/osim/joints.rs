//! Joints of OpenSim, all as three turns about and three slides along axes, each a function of a coordinate.

use super::function::Function;
use super::model::{Coordinate, Model, child, conjugate, inverse, objects, still};
use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use crate::description::mjcf::{HERE, Place, possible};
use crate::description::orientation::{about, product, rotate, unit};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

/// One turn or slide of a joint.
struct Axis<'a> {
    at: Attributes<'a>,
    turn: bool,
    axis: [f64; 3],
    coordinate: Option<(&'a str, Coordinate)>,
    function: Function,
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// Turns, in their order, and slides of a joint whose coordinates move it directly; turns first, as their
/// coordinates are.
fn plain(kind: &str) -> Option<&'static [(bool, [f64; 3])]> {
    Some(match kind {
        "WeldJoint" => &[],
        "PinJoint" => &[(true, Z)],
        "SliderJoint" => &[(false, X)],
        "UniversalJoint" => &[(true, X), (true, Y)],
        "GimbalJoint" | "BallJoint" => &[(true, X), (true, Y), (true, Z)],
        "FreeJoint" => &[(true, X), (true, Y), (true, Z), (false, X), (false, Y), (false, Z)],
        "PlanarJoint" => &[(true, Z), (false, X), (false, Y)],
        _ => return None,
    })
}

/// Reads all joints, parents before children, and the bodies that they carry.
pub(super) fn read(model: &mut Model<'_>) -> Result<(), DescriptionError> {
    let mut leaving: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    let mut parents = BTreeMap::new();
    for joint in objects(model.tree, model.element, "JointSet") {
        let name = joint.required("name")?;
        let (parent, outer) = model.frame(joint, "socket_parent_frame", name)?;
        let (child, inner) = model.frame(joint, "socket_child_frame", name)?;
        if child == "ground" || parents.insert(child, parent).is_some() {
            let problem =
                format!("carries `{child}`, which another joint or the ground holds: expected a tree");
            return Err(joint.error("socket_child_frame", problem));
        }
        leaving.entry(parent).or_default().push((joint, child, outer, inner));
    }
    let mut open = Vec::from(["ground"]);
    while let Some(parent) = open.pop() {
        for (joint, child, outer, inner) in leaving.remove(parent).unwrap_or_default() {
            let index = model.placed[parent];
            carry(model, joint, index, (child, outer, inner))?;
            open.push(child);
        }
    }
    let loose = model.bodies.iter().find(|(name, _)| **name != "ground" && !model.placed.contains_key(*name));
    match loose {
        Some((_, &element)) => {
            let problem =
                "hangs on no joint that leads to the ground: expected a tree of bodies on the ground";
            Err(model.tree.error(element, "", problem))
        }
        None => Ok(()),
    }
}

/// A turn or slide that a coordinate moves: its axis in the parent's frame of the joint, and its slope, where
/// it follows its coordinate linearly.
#[derive(Clone, Copy)]
struct Moving<'m, 'a> {
    axis: &'m Axis<'a>,
    along: [f64; 3],
    name: &'a str,
    slope: Option<f64>,
}

impl Moving<'_, '_> {
    /// Whether it can be the coordinate itself.
    fn is_one_to_one(&self) -> bool {
        self.slope.is_some_and(|slope| slope.abs().to_bits() == 1.0_f64.to_bits())
    }
}

/// Adds the body that a joint carries, with its joints.
fn carry<'a>(
    model: &mut Model<'a>,
    joint: Attributes<'a>,
    parent: usize,
    (name, outer, inner): (&'a str, Place, Place),
) -> Result<(), DescriptionError> {
    let axes = axes(model, joint)?;
    // What no coordinate moves turns and shifts what comes after it.
    let mut constant = HERE;
    let mut moving = Vec::new();
    for axis in axes.iter().filter(|axis| !axis.turn).chain(axes.iter().filter(|axis| axis.turn)) {
        let along = rotate(constant.orientation, axis.axis);
        let linear = axis.function.linear();
        let start = match axis.coordinate.filter(|(_, coordinate)| !coordinate.locked) {
            None => axis.function.value(axis.coordinate.map_or(0.0, |(_, coordinate)| coordinate.value)),
            Some((name, _)) => {
                if linear.is_none_or(|[_, slope]| slope != 0.0) {
                    moving.push(Moving { axis, along, name, slope: linear.map(|[_, slope]| slope) });
                }
                linear.map_or(0.0, |[start, _]| start)
            }
        };
        if axis.turn {
            constant.orientation = product(constant.orientation, about(axis.axis, start));
        } else {
            (0..3).for_each(|i| constant.position[i] += start * along[i]);
        }
    }
    // A coordinate that nothing follows one to one is a joint of a body without mass.
    for follower in &moving {
        let (name, same) = (follower.name, |other: &&Moving<'_, '_>| other.name == follower.name);
        if model.coordinates[name].joint.is_none() && !moving.iter().filter(same).any(Moving::is_one_to_one) {
            let body = model.parts.bodies.len();
            model.parts.bodies.push(still(&format!("{name}:coordinate"), 0, HERE));
            let turn = moving.iter().filter(same).any(|moving| moving.axis.turn);
            let carrier = model.add_joint(name, body, turn, follower.axis.axis, [0.0; 3]);
            settle(model, name, carrier);
        }
    }
    let index = model.parts.bodies.len();
    let mut body = still(name, parent, outer.of(constant).of(inverse(inner)));
    weigh(model, name, &mut body)?;
    model.describe("body", index, model.bodies[name]);
    model.parts.bodies.push(body);
    model.placed.insert(name, index);
    let to_body = product(inner.orientation, conjugate(constant.orientation));
    let mut followers = Vec::new();
    for Moving { axis, along, name, slope } in moving.iter().copied() {
        let own =
            Moving { axis, along, name, slope }.is_one_to_one() && model.coordinates[name].joint.is_none();
        let sign = slope.filter(|_| own).unwrap_or(1.0);
        let part = axis.at.text("name").unwrap_or_default();
        let title = if own { name.to_string() } else { format!("{}:{part}", joint.required("name")?) };
        let along = rotate(to_body, along.map(|x| sign * x));
        let added = model.add_joint(&title, index, axis.turn, along, inner.position);
        if own {
            settle(model, name, added);
        } else {
            model.describe("joint", added, axis.at.element);
            followers.push((added, axis, name, slope));
        }
    }
    for (follower, axis, name, slope) in followers {
        // The constant of a linear function is in the pose of the body.
        let function = slope.map_or_else(|| axis.function.clone(), |slope| Function::line(0.0, slope));
        model.follow(follower, axis.at, name, function);
    }
    Ok(())
}

/// Makes a joint that of a coordinate.
fn settle(model: &mut Model<'_>, name: &str, joint: usize) {
    let Some(coordinate) = model.coordinates.get_mut(name) else { return };
    coordinate.joint = Some(joint);
    let Coordinate { element, range, .. } = *coordinate;
    model.parts.joints[joint].range = range;
    model.describe("joint", joint, element);
}

/// The turns and slides of a joint.
fn axes<'a>(model: &Model<'a>, joint: Attributes<'a>) -> Result<Vec<Axis<'a>>, DescriptionError> {
    let tree = model.tree;
    let kind = tree.elements[joint.element].name.as_str();
    if let Some(plain) = plain(kind) {
        let coordinates = objects(tree, joint.element, "coordinates");
        if coordinates.len() != plain.len() {
            let problem = format!("has {} coordinates: expected {}", coordinates.len(), plain.len());
            return Err(joint.error("", problem));
        }
        let axis = |(&(turn, axis), at): (&(bool, [f64; 3]), Attributes<'a>)| {
            let coordinate = Some(model.coordinate(at, "name", at.required("name")?)?);
            Ok(Axis { at, turn, axis, coordinate, function: Function::line(0.0, 1.0) })
        };
        return plain.iter().zip(coordinates).map(axis).collect();
    }
    if kind != "CustomJoint" {
        let problem = format!(
            "is a <{}>, which is not read: expected a weld, pin, slider, universal, gimbal, ball, free, \
                planar or custom joint",
            shortened(kind)
        );
        return Err(joint.error("", problem));
    }
    let transform = child(tree, joint.element, "SpatialTransform")
        .ok_or_else(|| joint.error("", "has no <SpatialTransform>"))?;
    let all = tree.elements[transform.element]
        .children
        .iter()
        .filter(|&&e| tree.elements[e].name == "TransformAxis");
    let read = |&element: &usize| {
        let at = Attributes::own(tree, element);
        let turn = match at.required("name")? {
            "rotation1" | "rotation2" | "rotation3" => true,
            "translation1" | "translation2" | "translation3" => false,
            name => {
                let problem =
                    format!("is `{name}`: expected rotation1 to rotation3, translation1 to translation3");
                return Err(at.error("name", problem));
            }
        };
        let axis = unit(at.array("axis")?.ok_or_else(|| at.error("axis", "is missing"))?)
            .ok_or_else(|| at.error("axis", "has no direction: expected a vector that is not zero"))?;
        let names: Vec<&str> = at.text("coordinates").unwrap_or_default().split_ascii_whitespace().collect();
        let coordinate = match names[..] {
            [] => None,
            [name] => Some(model.coordinate(at, "coordinates", name)?),
            _ => return Err(at.error("coordinates", "has several: expected at most one coordinate")),
        };
        Ok(Axis { at, turn, axis, coordinate, function: Function::within(at)? })
    };
    all.map(read).collect()
}

/// Mass and inertia, where that is none of a body of matter, as OpenSim has it.
fn weigh(model: &mut Model<'_>, name: &str, body: &mut crate::body::Body) -> Result<(), DescriptionError> {
    let at = Attributes::own(model.tree, model.bodies[name]);
    body.mass = at.not_negative("mass")?;
    body.center_of_mass = at.array_or("mass_center", [0.0; 3])?;
    body.inertia = at.array_or("inertia", [0.0; 6])?;
    let [x, y, z, ..] = body.inertia;
    if body.mass == 0.0 && body.inertia.iter().any(|moment| *moment != 0.0) {
        body.inertia = [0.0; 6];
        let what = format!("`{name}` has an inertia, but no mass: its inertia is left out, as in OpenSim");
        model.left_out(at.element, &what, &what, false);
    } else if let Err(problem) = possible(body.inertia) {
        let same = libm::sqrt((x * x + y * y + z * z) / 3.0);
        body.inertia = [same, same, same, 0.0, 0.0, 0.0];
        let what =
            format!("`inertia` of `{name}` {problem}; it is {same} about every axis here, as in OpenSim");
        model.left_out(at.element, &what, &what, false);
    }
    Ok(())
}

/// Constraints: coordinates that follow others; warns of all else.
pub(super) fn constraints(model: &mut Model<'_>) -> Result<(), DescriptionError> {
    for at in objects(model.tree, model.element, "ConstraintSet") {
        if !at.flag("isEnforced", true)? {
            continue;
        }
        let kind = model.tree.elements[at.element].name.as_str();
        if kind != "CoordinateCouplerConstraint" {
            let kind = shortened(kind);
            model.left_out(
                at.element,
                &kind,
                &format!("<{kind}> is not read: what it ties is free here"),
                true,
            );
            continue;
        }
        let leader = at.required("independent_coordinate_names")?;
        if leader.split_ascii_whitespace().count() != 1 {
            return Err(
                at.error("independent_coordinate_names", format!("is `{leader}`: expected one coordinate"))
            );
        }
        let (leader, _) = model.coordinate(at, "independent_coordinate_names", leader)?;
        let follower = at.required("dependent_coordinate_name")?;
        let (_, follower) = model.coordinate(at, "dependent_coordinate_name", follower)?;
        let function = child(model.tree, at.element, "coupled_coordinates_function")
            .ok_or_else(|| at.error("coupled_coordinates_function", "is missing"))?;
        let mut function = Function::within(function)?;
        function.multiply(at.number_or("scale_factor", 1.0)?);
        // A follower that moves nothing needs no constraint; one that is locked does not follow.
        if let Some(joint) = follower.joint {
            model.follow(joint, at, leader, function);
        }
    }
    Ok(())
}
