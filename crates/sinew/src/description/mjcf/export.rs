//! From parts to MJCF that MuJoCo loads.

use super::sheath;
use super::text::{escape, numbers};
use crate::body::{JointKind, Parts, PathElement, TendonPath, WrapKind};
use crate::description::names::named;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt::Write as _;

/// The robot as MJCF: radians, no classes, every number in the shortest form that reads back to the same
/// bits.
///
/// Unnamed parts get a name (`site_3`), because tendons and actuators refer by name. MJCF has no sheaths:
/// they are custom data, which MuJoCo keeps and [`from_mjcf`](super::from_mjcf) reads.
#[must_use]
pub fn to_mjcf(parts: &Parts) -> String {
    let parts = &named(parts);
    let mut out = String::new();
    let _ = write!(
        out,
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\" autolimits=\"true\" \
            balanceinertia=\"false\"/>\n",
        escape(&parts.name)
    );
    let _ = writeln!(out, "  <option gravity=\"{}\"/>", numbers(&parts.gravity));
    sheath::write(&mut out, parts);
    bodies(&mut out, parts);
    tendons(&mut out, parts);
    equalities(&mut out, parts);
    actuators(&mut out, parts);
    if !parts.keys.is_empty() {
        out.push_str("  <keyframe>\n");
        for key in &parts.keys {
            let _ = writeln!(out, "    <key{} qpos=\"{}\"/>", name_of(&key.name), numbers(&key.q));
        }
        out.push_str("  </keyframe>\n");
    }
    out.push_str("</mujoco>\n");
    out
}

fn name_of(name: &str) -> String {
    format!(" name=\"{}\"", escape(name))
}

fn place(position: &[f64; 3], orientation: &[f64; 4]) -> String {
    let mut out = String::new();
    if position.iter().any(|x| x.to_bits() != 0) {
        let _ = write!(out, " pos=\"{}\"", numbers(position));
    }
    if orientation.map(f64::to_bits) != [1.0_f64, 0.0, 0.0, 0.0].map(f64::to_bits) {
        let _ = write!(out, " quat=\"{}\"", numbers(orientation));
    }
    out
}

fn nonzero(attribute: &str, value: f64) -> String {
    if value == 0.0 { String::new() } else { format!(" {attribute}=\"{value:?}\"") }
}

fn range(attribute: &str, limited: &str, range: Option<[f64; 2]>) -> String {
    range.map_or(String::new(), |range| format!(" {limited}=\"true\" {attribute}=\"{}\"", numbers(&range)))
}

fn bodies(out: &mut String, parts: &Parts) {
    let mut children: Vec<Vec<usize>> = parts.bodies.iter().map(|_| Vec::new()).collect();
    for (index, body) in parts.bodies.iter().enumerate().skip(1) {
        if let Some(list) = children.get_mut(body.parent) {
            list.push(index);
        }
    }
    out.push_str("  <worldbody>\n");
    contents(out, parts, 0, 2);
    // Bodies still to write, and end tags (`None`).
    let mut open: Vec<(Option<usize>, usize)> = Vec::new();
    open.extend(children.first().into_iter().flatten().rev().map(|&child| (Some(child), 2)));
    while let Some((index, depth)) = open.pop() {
        let indent = "  ".repeat(depth);
        let Some(index) = index else {
            let _ = writeln!(out, "{indent}</body>");
            continue;
        };
        let body = &parts.bodies[index];
        let _ = writeln!(
            out,
            "{indent}<body{}{}{}>",
            name_of(&body.name),
            place(&body.position, &body.orientation),
            nonzero("gravcomp", body.gravity_compensation)
        );
        let _ = writeln!(
            out,
            "{indent}  <inertial pos=\"{}\" mass=\"{:?}\" {}/>",
            numbers(&body.center_of_mass),
            body.mass,
            inertia(&body.inertia)
        );
        contents(out, parts, index, depth + 1);
        open.push((None, depth));
        open.extend(children[index].iter().rev().map(|&child| (Some(child), depth + 1)));
    }
    out.push_str("  </worldbody>\n");
}

/// Written as a diagonal where it is one: MuJoCo refuses a full tensor of zeros.
fn inertia(tensor: &[f64; 6]) -> String {
    if tensor[3..].iter().all(|x| *x == 0.0) {
        return format!("diaginertia=\"{}\"", numbers(&tensor[..3]));
    }
    format!("fullinertia=\"{}\"", numbers(tensor))
}

/// Content of one body except child bodies.
fn contents(out: &mut String, parts: &Parts, body: usize, depth: usize) {
    let indent = "  ".repeat(depth);
    for joint in parts.joints.iter().filter(|joint| joint.body == body) {
        let name = escape(&joint.name);
        let shape = match joint.kind {
            JointKind::Hinge => format!("type=\"hinge\" axis=\"{}\"", numbers(&joint.axis)),
            JointKind::Slide => format!("type=\"slide\" axis=\"{}\"", numbers(&joint.axis)),
            JointKind::Ball => "type=\"ball\"".to_string(),
            JointKind::Free => "type=\"free\"".to_string(),
        };
        let _ = writeln!(
            out,
            "{indent}<joint name=\"{name}\" {shape}{}{}{}{}{}{}{}{}/>",
            place(&joint.anchor, &[1.0, 0.0, 0.0, 0.0]),
            range("range", "limited", joint.range),
            nonzero("ref", joint.reference),
            nonzero("armature", joint.armature),
            nonzero("damping", joint.damping),
            nonzero("frictionloss", joint.friction),
            nonzero("stiffness", joint.stiffness),
            nonzero("springref", joint.spring_reference),
        );
    }
    for wrap in parts.wraps.iter().filter(|wrap| wrap.body == body) {
        // MuJoCo requires a half-length of a cylinder, which wrapping ignores.
        let (kind, size) = match wrap.kind {
            WrapKind::Sphere => ("sphere", numbers(&[wrap.radius])),
            WrapKind::Cylinder => ("cylinder", numbers(&[wrap.radius, wrap.radius])),
        };
        let _ = writeln!(
            out,
            "{indent}<geom name=\"{}\" type=\"{kind}\" size=\"{size}\" mass=\"0\" contype=\"0\" \
                conaffinity=\"0\"{}/>",
            escape(&wrap.name),
            place(&wrap.position, &wrap.orientation)
        );
    }
    for geom in parts.geoms.iter().filter(|geom| geom.body == body) {
        let _ = writeln!(
            out,
            "{indent}<geom type=\"{}\" size=\"{}\" mass=\"0\" contype=\"0\" conaffinity=\"0\"{}/>",
            geom.kind.word(),
            numbers(&geom.size[..geom.kind.sizes()]),
            place(&geom.position, &geom.orientation)
        );
    }
    for site in parts.sites.iter().filter(|site| site.body == body) {
        let name = escape(&site.name);
        let _ = writeln!(out, "{indent}<site name=\"{name}\"{}/>", place(&site.position, &site.orientation));
    }
}

fn tendons(out: &mut String, parts: &Parts) {
    if parts.tendons.is_empty() && parts.springs.is_empty() {
        return;
    }
    out.push_str("  <tendon>\n");
    for tendon in parts.tendons.iter().chain(&parts.springs) {
        let spring =
            tendon.spring_length.map_or(String::new(), |s| format!(" springlength=\"{}\"", numbers(&s)));
        let attributes = format!(
            " name=\"{}\"{}{}{}{spring}",
            escape(&tendon.name),
            range("range", "limited", tendon.range),
            nonzero("damping", tendon.damping),
            nonzero("stiffness", tendon.stiffness)
        );
        match &tendon.path {
            TendonPath::Spatial(elements) => {
                let _ = writeln!(out, "    <spatial{attributes}>");
                for element in elements {
                    let _ = writeln!(out, "      {}", path_element(parts, element));
                }
                out.push_str("    </spatial>\n");
            }
            TendonPath::Fixed(terms) => {
                let _ = writeln!(out, "    <fixed{attributes}>");
                for (joint, coefficient) in terms {
                    let _ = writeln!(
                        out,
                        "      <joint joint=\"{}\" coef=\"{coefficient:?}\"/>",
                        joint_name(parts, *joint)
                    );
                }
                out.push_str("    </fixed>\n");
            }
        }
    }
    out.push_str("  </tendon>\n");
}

fn joint_name(parts: &Parts, joint: usize) -> String {
    escape(parts.joints.get(joint).map_or("", |joint| &joint.name))
}

fn path_element(parts: &Parts, element: &PathElement) -> String {
    let site = |index: usize| escape(parts.sites.get(index).map_or("", |site| &site.name));
    match *element {
        PathElement::Site(index) => format!("<site site=\"{}\"/>", site(index)),
        PathElement::Pulley(divisor) => format!("<pulley divisor=\"{divisor:?}\"/>"),
        PathElement::Wrap { wrap, side } => {
            let side = side.map_or(String::new(), |side| format!(" sidesite=\"{}\"", site(side)));
            let name = parts.wraps.get(wrap).map_or("", |wrap| &wrap.name);
            format!("<geom geom=\"{}\"{side}/>", escape(name))
        }
    }
}

fn equalities(out: &mut String, parts: &Parts) {
    if parts.couplings.is_empty() {
        return;
    }
    out.push_str("  <equality>\n");
    for coupling in &parts.couplings {
        let leader = coupling
            .leader
            .map_or(String::new(), |joint| format!(" joint2=\"{}\"", joint_name(parts, joint)));
        let follower = joint_name(parts, coupling.follower);
        let range = coupling.leader.and_then(|leader| parts.joints.get(leader)?.range);
        let coefficients = numbers(&coupling.polynomial(range).0);
        let _ = writeln!(out, "    <joint joint1=\"{follower}\"{leader} polycoef=\"{coefficients}\"/>");
    }
    out.push_str("  </equality>\n");
}

fn actuators(out: &mut String, parts: &Parts) {
    // Springs are told from muscles by the actuators that muscles have.
    let driven = |muscle: usize| parts.actuators.iter().any(|actuator| actuator.tendon == muscle);
    let bare = (0..parts.tendons.len()).filter(|muscle| !parts.springs.is_empty() && !driven(*muscle));
    if parts.actuators.is_empty() && parts.springs.is_empty() {
        return;
    }
    out.push_str("  <actuator>\n");
    for muscle in bare {
        let _ = writeln!(out, "    <motor tendon=\"{}\" gear=\"-1\"/>", escape(&parts.tendons[muscle].name));
    }
    for actuator in &parts.actuators {
        let tendon = parts.tendons.get(actuator.tendon).map_or("", |tendon| &tendon.name);
        // Not every kind has `ctrllimited`; a given range is active.
        let control =
            actuator.control_range.map_or(String::new(), |r| format!(" ctrlrange=\"{}\"", numbers(&r)));
        let _ = write!(
            out,
            "    <{}{} tendon=\"{}\" gear=\"{:?}\"{control}{}",
            actuator.kind.word(),
            name_of(&actuator.name),
            escape(tendon),
            actuator.gear,
            range("forcerange", "forcelimited", actuator.force_range)
        );
        for (name, value) in &actuator.law {
            let _ = write!(out, " {name}=\"{}\"", escape(value));
        }
        out.push_str("/>\n");
    }
    out.push_str("  </actuator>\n");
}
