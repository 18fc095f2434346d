//! Names for unnamed parts, because files refer by name.

use crate::body::Parts;
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};

/// The same parts with unique names: `site_3` for an unnamed one, with a suffix where that is taken.
pub(super) fn named(parts: &Parts) -> Parts {
    let mut parts = parts.clone();
    if let Some(world) = parts.bodies.first_mut() {
        world.name = "world".to_string();
    }
    fill("body", parts.bodies.iter_mut().map(|part| &mut part.name).collect());
    fill("joint", parts.joints.iter_mut().map(|part| &mut part.name).collect());
    fill("site", parts.sites.iter_mut().map(|part| &mut part.name).collect());
    fill("wrap", parts.wraps.iter_mut().map(|part| &mut part.name).collect());
    fill("tendon", parts.tendons.iter_mut().chain(&mut parts.springs).map(|part| &mut part.name).collect());
    fill("actuator", parts.actuators.iter_mut().map(|part| &mut part.name).collect());
    fill("key", parts.keys.iter_mut().map(|part| &mut part.name).collect());
    parts
}

fn fill(kind: &str, mut names: alloc::vec::Vec<&mut String>) {
    let taken: BTreeSet<String> = names.iter().map(ToString::to_string).collect();
    for (index, name) in names.iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
        let mut own = format!("{kind}_{index}");
        while taken.contains(&own) {
            own.push('_');
        }
        **name = own;
    }
}
