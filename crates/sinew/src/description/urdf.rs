//! URDF, the robot format of ROS: links and joints; muscles come from a separate TOML.

use super::Description;
use super::attributes::{Attributes, shortened};
use super::error::{DescriptionError, Warning};
use super::orientation::{IDENTITY, euler, rotate, turn_tensor, unit};
use super::origin::Origins;
use super::robot_toml::add_muscles;
use super::tree::Tree;
use super::urdf_geoms;
use crate::body::{Body, Coupling, Joint, JointKind, Parts};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Reads a robot from URDF and, if given, its muscles from a TOML (name of that file and its text).
///
/// The root link is a body fixed to the world, or the world itself if it is named `world`.
///
/// # Errors
///
/// The first error: file, line, element, attribute, its value and what was expected.
pub fn from_urdf(
    file: &str,
    text: &str,
    muscles: Option<(&str, &str)>,
) -> Result<Description, DescriptionError> {
    let tree = Tree::parse(file, text, &mut |_| Err("URDF knows no include".to_string()))?;
    let root = Attributes::own(&tree, 0);
    if tree.elements[0].name != "robot" {
        return Err(root.error("", "is the root: expected <robot>"));
    }
    let mut parts = Parts {
        name: root.text("name").unwrap_or_default().to_string(),
        gravity: [0.0, 0.0, -9.81],
        ..Parts::default()
    };
    let mut warnings = Vec::new();
    spelt(&tree, &mut warnings)?;
    let graph = Graph::read(&tree)?;
    warnings.extend(graph.warnings.iter().cloned());
    graph.build(&mut parts)?;
    let mut origins = graph.origins(&parts, file);
    if let Some((file, text)) = muscles {
        (parts, origins) = add_muscles(parts, origins, file, text)?;
    }
    Ok(Description { parts, warnings, origins })
}

/// Links and joints by name, not ordered yet.
struct Graph<'a> {
    tree: &'a Tree,
    links: BTreeMap<&'a str, usize>,
    /// Joints to the children of a link, in document order.
    leaving: BTreeMap<&'a str, Vec<usize>>,
    root: &'a str,
    warnings: Vec<Warning>,
}

const KINDS: [&str; 6] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

/// Attributes of the elements that are read; other elements belong to other tools and are not checked.
fn attributes_of(name: &str) -> Option<&'static [&'static str]> {
    Some(match name {
        "link" => &["name", "type"],
        "joint" => &["name", "type"],
        "origin" => &["xyz", "rpy"],
        "mass" => &["value"],
        "inertia" => &["ixx", "iyy", "izz", "ixy", "ixz", "iyz"],
        "parent" | "child" => &["link"],
        "axis" => &["xyz"],
        "limit" => &["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"],
        "dynamics" => &["damping", "friction"],
        "mimic" => &["joint", "multiplier", "offset"],
        "inertial" => &[],
        _ => return None,
    })
}

/// Elements within those that are read.
fn children_of(name: &str) -> &'static [&'static str] {
    match name {
        "link" => &["inertial", "visual", "collision"],
        "joint" => &[
            "origin",
            "parent",
            "child",
            "axis",
            "calibration",
            "dynamics",
            "limit",
            "mimic",
            "safety_controller",
        ],
        "inertial" => &["origin", "mass", "inertia"],
        _ => &[],
    }
}

/// Refuses unknown attributes; warns once of unknown elements, which may belong to other tools.
fn spelt(tree: &Tree, warnings: &mut Vec<Warning>) -> Result<(), DescriptionError> {
    let mut warned = BTreeSet::new();
    let mut open = tree.elements[0].children.clone();
    open.retain(|&e| matches!(tree.elements[e].name.as_str(), "link" | "joint"));
    open.reverse();
    while let Some(element) = open.pop() {
        let here = &tree.elements[element];
        let Some(known) = attributes_of(&here.name) else { continue };
        if let Some((name, _)) = here.attributes.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            let problem = format!("is no attribute of it: expected one of {}", known.join(", "));
            return Err(tree.error(element, &shortened(name), problem));
        }
        let inside = open.len();
        for &child in &here.children {
            let inner = &tree.elements[child];
            if children_of(&here.name).contains(&inner.name.as_str()) {
                open.push(child);
            } else if warned.insert((here.name.as_str(), inner.name.as_str())) {
                let name = shortened(&inner.name);
                let what = format!("<{name}> in a <{}> is not read, what it says is left out", here.name);
                warnings.push(Warning {
                    file: tree.files[inner.file].clone(),
                    line: inner.line,
                    what,
                    changes_forces: false,
                });
            }
        }
        // In document order, so that a warning names the first of its kind.
        open[inside..].reverse();
    }
    Ok(())
}

/// Range of a hinge from which its limits are likely to be in degrees, rad.
const WIDEST_RANGE: f64 = 15.0;

/// What a file is likely not to mean: a link that a joint moves and that has no mass, a range in degrees.
fn doubtful(tree: &Tree, joint: usize, links: &BTreeMap<&str, usize>) -> Option<Warning> {
    let (kind, name) = (tree.elements[joint].attribute("type"), tree.elements[joint].attribute("name"));
    let name = shortened(name.unwrap_or_default());
    let at = |element: usize, what: String| Warning {
        file: tree.files[tree.elements[element].file].clone(),
        line: tree.elements[element].line,
        what,
        changes_forces: false,
    };
    let end = |limit: &Attributes<'_>, key| limit.text(key).and_then(|text| text.trim().parse::<f64>().ok());
    if let Some(limit) = child(tree, joint, "limit").filter(|_| kind == Some("revolute"))
        && let (Some(low), Some(high)) = (end(&limit, "lower"), end(&limit, "upper"))
        && high - low > WIDEST_RANGE
    {
        let range = high - low;
        return Some(at(
            joint,
            format!("joint `{name}` has a range of {range} rad: limits are not in degrees"),
        ));
    }
    let link = child(tree, joint, "child")?.text("link")?;
    let is_massless = child(tree, links.get(link).copied()?, "inertial").is_none();
    let moves = kind.is_some_and(|kind| kind != "fixed");
    let what = || format!("link `{}` moves and has no <inertial>: it has no mass", shortened(link));
    (moves && is_massless).then(|| at(links[link], what()))
}

impl<'a> Graph<'a> {
    fn read(tree: &'a Tree) -> Result<Graph<'a>, DescriptionError> {
        let (mut links, mut leaving) = (BTreeMap::new(), BTreeMap::<&str, Vec<usize>>::new());
        let (mut joints, mut children, mut warned, mut warnings) =
            (BTreeSet::new(), BTreeSet::new(), BTreeSet::new(), Vec::new());
        let of = |name: &'static str| {
            tree.elements[0].children.iter().copied().filter(move |&e| tree.elements[e].name == name)
        };
        for link in of("link") {
            let at = Attributes::own(tree, link);
            if links.insert(at.required("name")?, link).is_some() {
                return Err(at.error("name", "is taken already by another link"));
            }
        }
        for joint in of("joint") {
            let at = Attributes::own(tree, joint);
            if !joints.insert(at.required("name")?) {
                return Err(at.error("name", "is taken already by another joint"));
            }
            for (end, is_child) in [("parent", false), ("child", true)] {
                let inner = child(tree, joint, end).ok_or_else(|| at.error("", format!("has no <{end}>")))?;
                let name = inner.required("link")?;
                if !links.contains_key(name) {
                    return Err(
                        inner.error("link", format!("is `{name}`, but there is no link of that name"))
                    );
                }
                if !is_child {
                    leaving.entry(name).or_default().push(joint);
                } else if !children.insert(name) {
                    return Err(inner.error("link", format!("is `{name}`, which has a parent already")));
                }
            }
        }
        for &other in &tree.elements[0].children {
            let name = tree.elements[other].name.as_str();
            if !matches!(name, "link" | "joint" | "material" | "gazebo") && warned.insert(name) {
                let at = &tree.elements[other];
                let what = format!("<{name}> is not read, what it says is left out");
                warnings.push(Warning {
                    file: tree.files[at.file].clone(),
                    line: at.line,
                    what,
                    changes_forces: false,
                });
            }
        }
        warnings.extend(of("joint").filter_map(|joint| doubtful(tree, joint, &links)));
        let mut roots = links.keys().copied().filter(|name| !children.contains(name));
        let root = roots
            .next()
            .ok_or_else(|| tree.error(0, "", "has no link without a parent: expected one root"))?;
        if let Some(second) = roots.next() {
            let problem = format!("is a root beside `{root}`: expected one link without a parent");
            return Err(tree.error(links[second], "", problem));
        }
        Ok(Graph { tree, links, leaving, root, warnings })
    }

    /// File and line of the links and joints.
    fn origins(&self, parts: &Parts, file: &str) -> Origins {
        let mut origins = Origins::new(file);
        let line = |element: usize| self.tree.elements[element].line;
        for (index, body) in parts.bodies.iter().enumerate() {
            if let Some(&link) = self.links.get(body.name.as_str()) {
                origins.set("body", index, file, line(link));
            }
        }
        let leaving = self.leaving.values().flatten();
        let joints: BTreeMap<_, _> =
            leaving.map(|&joint| (self.tree.elements[joint].attribute("name"), line(joint))).collect();
        for (index, joint) in parts.joints.iter().enumerate() {
            if let Some(&line) = joints.get(&Some(joint.name.as_str())) {
                origins.set("joint", index, file, line);
            }
        }
        for (index, coupling) in parts.couplings.iter().enumerate() {
            if let Some(&line) = joints.get(&Some(parts.joints[coupling.follower].name.as_str())) {
                origins.set("coupling", index, file, line);
            }
        }
        origins
    }

    /// Bodies from the root on, parents before children.
    fn build(&self, parts: &mut Parts) -> Result<(), DescriptionError> {
        parts.bodies.push(still("world"));
        let mut root = 0;
        if self.root != "world" {
            parts.bodies.push(still(self.root));
            root = 1;
            weigh(self.tree, self.links[self.root], &mut parts.bodies[1])?;
            urdf_geoms::read(self.tree, self.links[self.root], 1, origin, parts)?;
        }
        let mut mimics = Vec::new();
        let leaving = |link: &str| self.leaving.get(link).into_iter().flatten().rev().copied();
        let mut open: Vec<(usize, usize)> = leaving(self.root).map(|joint| (joint, root)).collect();
        while let Some((element, parent)) = open.pop() {
            let at = Attributes::own(self.tree, element);
            let link =
                child(self.tree, element, "child").map_or("", |child| child.text("link").unwrap_or_default());
            let index = parts.bodies.len();
            let mut body = still(link);
            body.parent = parent;
            (body.position, body.orientation) = origin(self.tree, element)?;
            weigh(self.tree, self.links[link], &mut body)?;
            urdf_geoms::read(self.tree, self.links[link], index, origin, parts)?;
            let kind = at.word("type", &KINDS)?.ok_or_else(|| at.error("type", "is missing"))?;
            if kind == 5 {
                return Err(at.error(
                    "type",
                    "is `planar`, which is not read: expected two prismatic joints and a revolute one",
                ));
            }
            if kind == 4 {
                if parent != root || root == 1 && parts.bodies[1].mass > 0.0 {
                    return Err(
                        at.error("type", "is `floating`: expected that only of a massless root's child")
                    );
                }
                body.parent = 0;
            }
            if link == "world" {
                return Err(at.error("", "moves the link `world`, which does not move"));
            }
            parts.bodies.push(body);
            if kind != 3 {
                if let Some(mimic) = child(self.tree, element, "mimic") {
                    mimics.push((parts.joints.len(), mimic));
                }
                parts.joints.push(joint(self.tree, at, kind, index)?);
            }
            open.extend(leaving(link).map(|joint| (joint, index)));
        }
        if parts.bodies.len() - 1 + usize::from(root == 0) != self.links.len() {
            return Err(self.tree.error(0, "", "has joints in a circle: expected a tree of links"));
        }
        for (follower, mimic) in mimics {
            let name = mimic.required("joint")?;
            let leader = parts.joints.iter().position(|joint| joint.name == name);
            let leader = leader.ok_or_else(|| {
                mimic.error("joint", format!("is `{name}`, but no joint of that name moves"))
            })?;
            let coefficients =
                [mimic.number_or("offset", 0.0)?, mimic.number_or("multiplier", 1.0)?, 0.0, 0.0, 0.0];
            parts.couplings.push(Coupling {
                follower,
                leader: Some(leader),
                coefficients,
                pieces: Vec::new(),
            });
        }
        Ok(())
    }
}

fn still(name: &str) -> Body {
    Body {
        name: name.to_string(),
        parent: 0,
        position: [0.0; 3],
        orientation: IDENTITY,
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
        gravity_compensation: 0.0,
    }
}

fn child<'a>(tree: &'a Tree, element: usize, name: &str) -> Option<Attributes<'a>> {
    let found = tree.elements[element].children.iter().copied().find(|&e| tree.elements[e].name == name);
    found.map(|element| Attributes::own(tree, element))
}

/// `<origin xyz rpy>` of an element: fixed axes x, then y, then z.
fn origin(tree: &Tree, element: usize) -> Result<([f64; 3], [f64; 4]), DescriptionError> {
    let Some(at) = child(tree, element, "origin") else { return Ok(([0.0; 3], IDENTITY)) };
    let angles = at.array_or("rpy", [0.0; 3])?;
    let turned = angles.iter().any(|angle| *angle != 0.0);
    Ok((at.array_or("xyz", [0.0; 3])?, if turned { euler(angles, *b"XYZ") } else { IDENTITY }))
}

fn weigh(tree: &Tree, link: usize, body: &mut Body) -> Result<(), DescriptionError> {
    let Some(inertial) = child(tree, link, "inertial") else { return Ok(()) };
    let inside = |name: &str| {
        child(tree, inertial.element, name).ok_or_else(|| inertial.error("", format!("has no <{name}>")))
    };
    let (center, orientation) = origin(tree, inertial.element)?;
    let mass = inside("mass")?;
    mass.required("value")?;
    body.mass = mass.not_negative("value")?;
    let at = inside("inertia")?;
    let mut tensor = [0.0; 6];
    for (value, name) in tensor.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]) {
        *value = at.number_or(name, 0.0)?;
    }
    if let Err(problem) = super::mjcf::possible(tensor) {
        return Err(at.error("", problem));
    }
    body.center_of_mass = center;
    body.inertia = turn_tensor(orientation, tensor);
    Ok(())
}

fn joint(tree: &Tree, at: Attributes<'_>, kind: usize, body: usize) -> Result<Joint, DescriptionError> {
    let axis = match child(tree, at.element, "axis") {
        Some(axis) if kind < 3 => unit(axis.array_or("xyz", [1.0, 0.0, 0.0])?)
            .ok_or_else(|| axis.error("xyz", "is zero: expected a direction"))?,
        _ => [1.0, 0.0, 0.0],
    };
    let mut range = None;
    if kind == 0 || kind == 2 {
        let limit = child(tree, at.element, "limit").ok_or_else(|| at.error("", "has no <limit>"))?;
        let (low, high) = (limit.number_or("lower", 0.0)?, limit.number_or("upper", 0.0)?);
        if low > high {
            return Err(limit.error(
                "lower",
                format!("is {low}, upper {high}: expected a low end not above the high end"),
            ));
        }
        range = Some([low, high]);
    }
    let dynamics = child(tree, at.element, "dynamics");
    let loss = |name: &str| dynamics.map_or(Ok(0.0), |dynamics| dynamics.not_negative(name));
    Ok(Joint {
        name: at.required("name")?.to_string(),
        body,
        kind: [JointKind::Hinge, JointKind::Hinge, JointKind::Slide, JointKind::Hinge, JointKind::Free]
            [kind.min(4)],
        anchor: [0.0; 3],
        axis: rotate(IDENTITY, axis),
        reference: 0.0,
        range,
        armature: 0.0,
        damping: loss("damping")?,
        friction: loss("friction")?,
        stiffness: 0.0,
        spring_reference: 0.0,
        flex: 0.0,
    })
}
