//! From parts to this project's TOML.

use crate::body::{Joint, JointKind, Parts, PathElement, TendonPath, WrapKind};
use crate::description::names::named;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write as _;

/// The robot in this project's own format; numbers read back to the same bits.
///
/// Unnamed parts get a name (`site_3`), because the format refers by name.
#[must_use]
pub fn to_toml(parts: &Parts) -> String {
    let parts = &named(parts);
    let mut out = String::from(
        "# SI units; orientations are quaternions [w, x, y, z]; the world is the body `world`.\n",
    );
    line(&mut out, "name", &text(&parts.name));
    line(&mut out, "gravity_m_per_s2", &numbers(&parts.gravity));
    bodies(&mut out, parts);
    joints(&mut out, parts);
    sites(&mut out, parts);
    geoms(&mut out, parts);
    muscles(&mut out, parts);
    springs(&mut out, parts);
    rest(&mut out, parts);
    out
}

fn line(out: &mut String, key: &str, value: &str) {
    let _ = writeln!(out, "{key} = {value}");
}

fn head(out: &mut String, kind: &str, name: &str) {
    let _ = write!(out, "\n[[{kind}]]\nname = {}\n", text(name));
}

fn number(value: f64) -> String {
    format!("{value:?}")
}

fn numbers(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", "))
}

/// A TOML string.
fn text(value: &str) -> String {
    let mut out = String::from("\"");
    for c in value.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", c as u32);
            }
            c => out.push(c),
        }
    }
    out + "\""
}

fn place(out: &mut String, position: &[f64; 3], orientation: &[f64; 4]) {
    line(out, "position_m", &numbers(position));
    if orientation.map(f64::to_bits) != [1.0_f64, 0.0, 0.0, 0.0].map(f64::to_bits) {
        line(out, "orientation_wxyz", &numbers(orientation));
    }
}

fn body_name(parts: &Parts, index: usize) -> &str {
    parts.bodies.get(index).map_or("", |body| &body.name)
}

fn joint_name(parts: &Parts, index: usize) -> &str {
    parts.joints.get(index).map_or("", |joint| &joint.name)
}

fn bodies(out: &mut String, parts: &Parts) {
    for (index, body) in parts.bodies.iter().enumerate().skip(1) {
        head(out, "body", body_name(parts, index));
        line(out, "parent", &text(body_name(parts, body.parent)));
        place(out, &body.position, &body.orientation);
        line(out, "mass_kg", &number(body.mass));
        line(out, "center_of_mass_m", &numbers(&body.center_of_mass));
        let diagonal = body.inertia[3..].iter().all(|x| x.to_bits() == 0);
        line(out, "inertia_kg_m2", &numbers(if diagonal { &body.inertia[..3] } else { &body.inertia }));
        if body.gravity_compensation != 0.0 {
            line(out, "gravity_compensation", &number(body.gravity_compensation));
        }
    }
}

fn joints(out: &mut String, parts: &Parts) {
    for joint in &parts.joints {
        head(out, "joint", &joint.name);
        line(out, "body", &text(body_name(parts, joint.body)));
        self::joint(out, joint);
    }
}

fn joint(out: &mut String, joint: &Joint) {
    let (kind, slide) = match joint.kind {
        JointKind::Hinge => ("hinge", false),
        JointKind::Slide => ("slide", true),
        JointKind::Ball => ("ball", false),
        JointKind::Free => ("free", false),
    };
    line(out, "kind", &text(kind));
    if joint.kind != JointKind::Free {
        line(out, "anchor_m", &numbers(&joint.anchor));
    }
    if matches!(joint.kind, JointKind::Hinge | JointKind::Slide) {
        line(out, "axis", &numbers(&joint.axis));
    }
    if let Some(range) = joint.range {
        line(out, if slide { "range_m" } else { "range_rad" }, &numbers(&range));
    }
    let optional = [
        ("reference_rad", "reference_m", joint.reference),
        ("armature_kg_m2", "armature_kg", joint.armature),
        ("damping_nm_s_per_rad", "damping_n_s_per_m", joint.damping),
        ("friction_nm", "friction_n", joint.friction),
        ("stiffness_nm_per_rad", "stiffness_n_per_m", joint.stiffness),
        ("spring_reference_rad", "spring_reference_m", joint.spring_reference),
    ];
    for (turning, sliding, value) in optional {
        if value.to_bits() != 0 {
            line(out, if slide { sliding } else { turning }, &number(value));
        }
    }
}

fn sites(out: &mut String, parts: &Parts) {
    for site in &parts.sites {
        head(out, "site", &site.name);
        line(out, "body", &text(body_name(parts, site.body)));
        place(out, &site.position, &site.orientation);
        if let Some((joint, range)) = site.active {
            let key = if parts.joints[joint].kind == JointKind::Slide { "range_m" } else { "range_rad" };
            let value =
                format!("{{ joint = {}, {key} = {} }}", text(joint_name(parts, joint)), numbers(&range));
            line(out, "active", &value);
        }
    }
    for wrap in &parts.wraps {
        head(out, "wrap", &wrap.name);
        line(out, "body", &text(body_name(parts, wrap.body)));
        let kind = match wrap.kind {
            WrapKind::Sphere => "sphere",
            WrapKind::Cylinder => "cylinder",
        };
        line(out, "kind", &text(kind));
        line(out, "radius_m", &number(wrap.radius));
        place(out, &wrap.position, &wrap.orientation);
    }
}

fn geoms(out: &mut String, parts: &Parts) {
    for geom in &parts.geoms {
        let _ = write!(out, "\n[[geom]]\nbody = {}\n", text(body_name(parts, geom.body)));
        line(out, "kind", &text(geom.kind.word()));
        line(out, "size_m", &numbers(&geom.size[..geom.kind.sizes()]));
        place(out, &geom.position, &geom.orientation);
    }
}

fn path(out: &mut String, parts: &Parts, path: &TendonPath) {
    match path {
        TendonPath::Spatial(elements) => {
            out.push_str("path = [\n");
            for element in elements {
                let _ = writeln!(out, "    {},", path_element(parts, element));
            }
        }
        TendonPath::Fixed(terms) => {
            out.push_str("joints = [\n");
            for &(joint, coefficient) in terms {
                let joint = text(joint_name(parts, joint));
                let _ = writeln!(out, "    {{ joint = {joint}, coefficient = {coefficient:?} }},");
            }
        }
    }
    out.push_str("]\n");
}

fn springs(out: &mut String, parts: &Parts) {
    for spring in &parts.springs {
        head(out, "spring", &spring.name);
        path(out, parts, &spring.path);
        line(out, "stiffness_n_per_m", &number(spring.stiffness));
        line(out, "damping_n_s_per_m", &number(spring.damping));
        if let Some(slack) = spring.spring_length {
            line(out, "slack_lengths_m", &numbers(&slack));
        }
    }
}

fn muscles(out: &mut String, parts: &Parts) {
    for tendon in &parts.tendons {
        head(out, "muscle", &tendon.name);
        path(out, parts, &tendon.path);
        if let Some(sheath) = &tendon.sheath {
            let axis =
                sheath.end_axis.map_or(String::new(), |axis| format!(", end_axis = {}", numbers(&axis)));
            let (length, bend) = (sheath.length, sheath.bend);
            let _ = writeln!(out, "sheath = {{ length_m = {length:?}, bend_rad = {bend:?}{axis} }}");
        }
        if let Some(range) = tendon.range {
            line(out, "length_range_m", &numbers(&range));
        }
        for (key, value) in [("damping_n_s_per_m", tendon.damping), ("stiffness_n_per_m", tendon.stiffness)] {
            if value.to_bits() != 0 {
                line(out, key, &number(value));
            }
        }
        if let Some(spring) = tendon.spring_length {
            line(out, "spring_length_m", &numbers(&spring));
        }
    }
}

fn path_element(parts: &Parts, element: &PathElement) -> String {
    let site = |index: usize| text(parts.sites.get(index).map_or("", |site| &site.name));
    match *element {
        PathElement::Site(index) => format!("{{ site = {} }}", site(index)),
        PathElement::Pulley(divisor) => format!("{{ pulley = {divisor:?} }}"),
        PathElement::Wrap { wrap, side } => {
            let side = side.map_or(String::new(), |side| format!(", side = {}", site(side)));
            let wrap = text(parts.wraps.get(wrap).map_or("", |wrap| &wrap.name));
            format!("{{ wrap = {wrap}{side} }}")
        }
    }
}

fn rest(out: &mut String, parts: &Parts) {
    for coupling in &parts.couplings {
        let _ = write!(out, "\n[[coupling]]\nfollower = {}\n", text(joint_name(parts, coupling.follower)));
        if let Some(leader) = coupling.leader {
            line(out, "leader", &text(joint_name(parts, leader)));
        }
        if coupling.pieces.is_empty() {
            line(out, "coefficients", &numbers(&coupling.coefficients));
        } else {
            let pieces: Vec<String> = coupling.pieces.iter().map(|piece| numbers(piece)).collect();
            line(out, "pieces", &format!("[{}]", pieces.join(", ")));
        }
    }
    for actuator in &parts.actuators {
        head(out, "actuator", &actuator.name);
        let muscle = parts.tendons.get(actuator.tendon).map_or("", |tendon| &tendon.name);
        line(out, "muscle", &text(muscle));
        line(out, "kind", &text(actuator.kind.word()));
        line(out, "gear", &number(actuator.gear));
        if let Some(range) = actuator.control_range {
            line(out, "control_range", &numbers(&range));
        }
        if let Some(range) = actuator.force_range {
            line(out, "force_range_n", &numbers(&range));
        }
        if !actuator.law.is_empty() {
            let law: Vec<String> =
                actuator.law.iter().map(|(key, value)| format!("{key} = {}", text(value))).collect();
            line(out, "law", &format!("{{ {} }}", law.join(", ")));
        }
    }
    for key in &parts.keys {
        head(out, "key", &key.name);
        line(out, "q", &numbers(&key.q));
    }
}
