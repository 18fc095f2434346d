//! The schema of MJCF: unknown elements and attributes are refused.

use crate::description::attributes::shortened;
use crate::description::error::DescriptionError;
use crate::description::spelling::near;
use crate::description::tree::Tree;
use alloc::format;
use alloc::vec::Vec;

/// MuJoCo's own schema (`benches/peers/mjcf_schema.py`): one element per line, indented within its parent,
/// with its multiplicity and attributes.
const SCHEMA: &str = include_str!("schema.txt");

/// One line of the schema.
struct Entry<'a> {
    name: &'a str,
    /// May contain itself.
    recursive: bool,
    attributes: Vec<&'a str>,
    children: Vec<usize>,
}

fn entries() -> Vec<Entry<'static>> {
    let mut entries: Vec<Entry<'static>> = Vec::new();
    let mut path: Vec<usize> = Vec::new();
    for line in SCHEMA.lines() {
        let depth = line.len() - line.trim_start().len();
        let mut words = line.split_ascii_whitespace();
        let name = words.next().unwrap_or_default().trim_start_matches("(world)");
        let recursive = words.next() == Some("R");
        path.truncate(depth);
        if let Some(&parent) = path.last() {
            let index = entries.len();
            entries[parent].children.push(index);
        }
        path.push(entries.len());
        entries.push(Entry { name, recursive, attributes: words.collect(), children: Vec::new() });
    }
    entries
}

/// The schema's name of an element: frames and copies have the content of bodies.
fn listed(name: &str) -> &str {
    match name {
        "worldbody" | "frame" | "replicate" => "body",
        name => name,
    }
}

/// Attributes in addition to those of the schema.
fn more(name: &str) -> &'static [&'static str] {
    match name {
        "replicate" => &["count", "offset", "sep", "prefix", "childclass", "euler"],
        "composite" | "flexcomp" => &["prefix"],
        _ => &[],
    }
}

/// Checks that MuJoCo has every element and attribute at its position.
pub(super) fn check(tree: &Tree) -> Result<(), DescriptionError> {
    let entries = entries();
    let mut open = Vec::from([(0, 0)]);
    while let Some((element, at)) = open.pop() {
        let (here, entry) = (&tree.elements[element], &entries[at]);
        for (attribute, _) in &here.attributes {
            let name = attribute.as_str();
            if !entry.attributes.contains(&name) && !more(&here.name).contains(&name) {
                let near = near(name, &entry.attributes);
                return Err(tree.error(element, &shortened(name), format!("is no attribute of it{near}")));
            }
        }
        for &child in here.children.iter().rev() {
            let name = tree.elements[child].name.as_str();
            let same = (entry.recursive && listed(name) == entry.name).then_some(at);
            let within = || entry.children.iter().copied().find(|&c| entries[c].name == listed(name));
            let Some(found) = same.or_else(within) else {
                let names: Vec<&str> = entry.children.iter().map(|&c| entries[c].name).collect();
                let problem = format!("is no element of <{}>{}", here.name, near(name, &names));
                return Err(tree.error(child, "", problem));
            };
            open.push((child, found));
        }
    }
    Ok(())
}

/// Attributes of an actuator for name, transmission and limits; all others belong to its force law.
const NO_LAW: [&str; 17] = [
    "name",
    "class",
    "group",
    "user",
    "gear",
    "ctrllimited",
    "ctrlrange",
    "forcelimited",
    "forcerange",
    "joint",
    "jointinparent",
    "site",
    "refsite",
    "slidersite",
    "cranksite",
    "body",
    "tendon",
];

/// Attributes of the force law of an actuator element.
pub(in crate::description) fn law(actuator: &str) -> Vec<&'static str> {
    let entries = entries();
    let all = entries.iter().find(|entry| entry.name == "actuator" && !entry.children.is_empty());
    let mut kinds = all.into_iter().flat_map(|all| all.children.iter().map(|&child| &entries[child]));
    let attributes = kinds.find(|entry| entry.name == actuator).map(|entry| &entry.attributes);
    attributes.into_iter().flatten().copied().filter(|name| of_law(name)).collect()
}

/// Whether an attribute of an actuator belongs to its force law.
pub(super) fn of_law(attribute: &str) -> bool {
    !NO_LAW.contains(&attribute)
}
