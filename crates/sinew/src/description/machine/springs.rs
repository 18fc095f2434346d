//! Which tendons of a body are muscles, and which are springs.

use super::listing::{Listing, Value, ValueSource};
use super::places::own_tables;
use crate::body::{Parts, Tendon};
use crate::description::Description;
use crate::description::document::Table;
use crate::description::error::Warning;
use crate::description::robot_toml::spring_tables;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Moves the tendons of a body that nothing pulls to its springs: those without an actuator where others have
/// one, and those that the machine file names a `[[spring]]`. A tendon with a `[[transmission]]` is a muscle.
///
/// One that neither pulls nor damps exerts no force and is left out, with a warning.
pub(super) fn divide(root: &Table<'_>, description: &mut Description) {
    let Description { parts, warnings, origins } = description;
    let muscles = own_tables(root);
    let driven = |index: usize| parts.actuators.iter().any(|actuator| actuator.tendon == index);
    let own = |tendon: &Tendon| muscles.iter().any(|(muscle, _)| *muscle == tendon.name);
    let springs = spring_tables(root);
    let is_muscle = |index: usize, tendon: &Tendon| {
        driven(index)
            || own(tendon)
            || parts.actuators.is_empty() && springs.iter().all(|(spring, _)| *spring != tendon.name)
    };
    let muscle: Vec<bool> =
        parts.tendons.iter().enumerate().map(|(k, tendon)| is_muscle(k, tendon)).collect();
    if muscle.iter().all(|muscle| *muscle) {
        return;
    }
    let place = |k: usize| muscle[..k].iter().filter(|muscle| **muscle).count();
    parts.actuators.iter_mut().for_each(|actuator| actuator.tendon = place(actuator.tendon));
    let (mut kept, mut cords) = (Vec::new(), Vec::new());
    for (k, tendon) in core::mem::take(&mut parts.tendons).into_iter().enumerate() {
        let (file, line) = origins.of("tendon", k, "");
        if muscle[k] {
            if origins.has("tendon", k) {
                origins.set("tendon", kept.len(), &file, line);
            }
            kept.push(tendon);
        } else if tendon.stiffness > 0.0 || tendon.damping > 0.0 {
            if tendon.range.is_some() {
                let what = format!("the range of the spring `{}` holds nothing", tendon.name);
                warnings.push(Warning { file: file.clone(), line, what, changes_forces: false });
            }
            origins.set("spring", parts.springs.len(), &file, line);
            parts.springs.push(tendon);
        } else {
            cords.push((tendon.name, file, line));
        }
    }
    parts.tendons = kept;
    if let Some((_, file, line)) = cords.first() {
        let names: Vec<String> = cords.iter().map(|(name, ..)| format!("`{name}`")).collect();
        let what = format!(
            "no actuator pulls {}, without stiffness or damping: left out, as no muscle and no spring",
            names.join(", ")
        );
        warnings.push(Warning { file: file.clone(), line: *line, what, changes_forces: false });
    }
}

/// Lists the springs, those beside muscles, too.
pub(super) fn list(root: &Table<'_>, parts: &Parts, listing: &mut Listing) {
    let own = spring_tables(root);
    let acts = |tendon: &&Tendon| tendon.stiffness > 0.0 || tendon.damping > 0.0;
    for spring in parts.tendons.iter().chain(&parts.springs).filter(acts) {
        listing.begin(&format!("[[spring]] `{}`", spring.name));
        let table = own.iter().find(|(name, _)| *name == spring.name);
        let source = table.map_or(ValueSource::Body, |(_, line)| ValueSource::File { line: *line });
        listing.number("stiffness_n_per_m", spring.stiffness, source);
        listing.number("damping_n_s_per_m", spring.damping, source);
        let slack = spring.spring_length.map_or(Value::None, |slack| Value::Numbers(slack.to_vec()));
        listing.add("slack_lengths_m", slack, source);
    }
}
