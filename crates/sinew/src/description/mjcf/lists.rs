//! Couplings, actuators and key poses.

use super::defaults::completed;
use super::import_state::Import;
use super::ranges::limits;
use super::schema;
use crate::body::{Actuator, ActuatorKind, Coupling, JointKind, Key};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

pub(super) fn equality(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = import.attributes(element, None)?;
    let kind = import.tree.elements[element].name.as_str();
    let at = Attributes::own(at.tree, element);
    if !at.flag("active", true)? {
        return Ok(());
    }
    if kind != "joint" {
        let what = format!("<equality> <{kind}> is not read: what it ties is free here");
        import.without(element, kind, &what);
        return Ok(());
    }
    let single = |joint: usize, attribute: &str, import: &Import<'_>| {
        if matches!(import.parts.joints[joint].kind, JointKind::Ball | JointKind::Free) {
            return Err(at.error(attribute, "has more than one coordinate: expected a hinge or a slide"));
        }
        Ok(joint)
    };
    let follower = single(import.find("joint", at, "joint1")?, "joint1", import)?;
    let leader = match at.text("joint2") {
        Some(_) => Some(single(import.find("joint", at, "joint2")?, "joint2", import)?),
        None => None,
    };
    let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
    for (c, given) in coefficients.iter_mut().zip(at.list("polycoef", 1, 5)?.unwrap_or_default()) {
        *c = given;
    }
    import.describe("coupling", import.parts.couplings.len(), at);
    import.parts.couplings.push(Coupling { follower, leader, coefficients, pieces: Vec::new() });
    Ok(())
}

pub(super) fn actuator(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let tag = import.tree.elements[element].name.as_str();
    let Some(kind) = ActuatorKind::from_word(tag) else {
        import.pass_over(element, "actuator", &format!("<{tag}> acts on no tendon, it is left out"));
        return Ok(());
    };
    let at = import.attributes(element, None)?;
    let name = import.name_as("actuator", at, import.parts.actuators.len())?.unwrap_or_default();
    if at.text("tendon").is_none() {
        import.pass_over(element, "on no tendon", "an actuator that pulls on no tendon is left out");
        return Ok(());
    }
    let mut law = BTreeMap::new();
    for name in schema::law(tag) {
        if let Some(text) = at.text(name) {
            finite(text).map_err(|problem| at.error(name, problem))?;
            law.insert(name.to_string(), completed(text, at.given.and_then(|given| given.get(name))));
        }
    }
    other_laws(import, at, &law);
    let auto = import.compiler.auto_limits;
    let actuator = Actuator {
        name,
        kind,
        tendon: import.find("tendon", at, "tendon")?,
        gear: at.list("gear", 1, 6)?.map_or(1.0, |gear| gear[0]),
        control_range: limits(at, auto, "ctrllimited", "ctrlrange")?,
        force_range: limits(at, auto, "forcelimited", "forcerange")?,
        law,
    };
    import.parts.actuators.push(actuator);
    Ok(())
}

/// Defaults given in the terms of another kind of actuator, which MuJoCo would translate.
fn other_laws(import: &mut Import<'_>, at: Attributes<'_>, law: &BTreeMap<String, String>) {
    let names = at.given.into_iter().flat_map(|given| given.keys());
    let Some(name) = names.into_iter().find(|name| !law.contains_key(*name) && schema::of_law(name)) else {
        return;
    };
    let tag = &at.tree.elements[at.element].name;
    let what = format!("`{name}` that its class gives to a <{tag}> is another actuator's, it is left out");
    import.pass_over(at.element, &format!("{tag} {name}"), &what);
}

/// Checks the values of a force law: no word is NaN or infinite.
pub(in crate::description) fn finite(text: &str) -> Result<(), String> {
    let wrong = |word: &str| word.parse::<f64>().is_ok_and(|number| !number.is_finite());
    match text.split_ascii_whitespace().find(|word| wrong(word)) {
        Some(word) => Err(format!("has `{word}` in it: expected finite numbers")),
        None => Ok(()),
    }
}

pub(super) fn key(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = Attributes::own(import.tree, element);
    let name = import.name_as("key", at, import.parts.keys.len())?.unwrap_or_default();
    let mut q = reference(import);
    if let Some(given) = at.list("qpos", q.len(), q.len())? {
        q = given;
        let mut from = 0;
        for joint in &import.parts.joints {
            let (skip, width) = match joint.kind {
                JointKind::Hinge | JointKind::Slide => (1, 0),
                JointKind::Ball => (0, 4),
                JointKind::Free => (3, 4),
            };
            if width == 4 {
                let quat = core::array::from_fn(|i| q[from + skip + i]);
                let quat = turn::unit::<4>(quat).unwrap_or(turn::IDENTITY);
                q[from + skip..from + skip + 4].copy_from_slice(&quat);
            }
            from += skip + width;
        }
    }
    import.parts.keys.push(Key { name, q });
    Ok(())
}

/// All coordinates of the pose of the description.
fn reference(import: &Import<'_>) -> Vec<f64> {
    let mut q = Vec::new();
    for joint in &import.parts.joints {
        match joint.kind {
            JointKind::Hinge | JointKind::Slide => q.push(joint.reference),
            JointKind::Ball => q.extend(turn::IDENTITY),
            JointKind::Free => {
                let body = &import.parts.bodies[joint.body];
                q.extend(body.position);
                q.extend(body.orientation);
            }
        }
    }
    q
}
