//! What refers to an element that is replicated is replicated with it: tendons, actuators and couplings.

use crate::description::error::DescriptionError;
use crate::description::tree::Tree;
use alloc::collections::BTreeSet;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Kind and name of an element.
type Named = (&'static str, String);

/// Kinds of elements that others refer to by name.
const KINDS: [&str; 4] = ["body", "joint", "geom", "site"];

/// The kind that an attribute names.
fn kind_of(attribute: &str) -> Option<&'static str> {
    Some(match attribute {
        "site" | "sidesite" => "site",
        "geom" => "geom",
        "joint" | "joint1" | "joint2" => "joint",
        "tendon" => "tendon",
        _ => return None,
    })
}

/// Names of elements below one, itself left out.
pub(super) fn names_within(tree: &Tree, element: usize) -> BTreeSet<Named> {
    let mut found = BTreeSet::new();
    let mut open: Vec<usize> = tree.elements[element].children.clone();
    while let Some(at) = open.pop() {
        let element = &tree.elements[at];
        open.extend(&element.children);
        let kind = KINDS.iter().find(|kind| **kind == element.name);
        if let (Some(kind), Some(name)) = (kind, element.attribute("name")) {
            found.insert((*kind, name.to_string()));
        }
    }
    found
}

/// Replaces elements of the outermost level that refer to one of `names` by a copy with every suffix, with
/// `copy` an element and its subtree with a suffix to its names. Copies stand behind the others, all of the
/// first suffix before those of the second, as MuJoCo's.
pub(super) fn follow(
    tree: &mut Tree,
    mut names: BTreeSet<Named>,
    suffixes: &[String],
    copy: impl Fn(&mut Tree, usize, &str) -> Result<usize, DescriptionError>,
) -> Result<(), DescriptionError> {
    // Actuators may refer to the copies of tendons.
    for section in ["tendon", "equality", "actuator"] {
        let sections = tree.elements[0].children.iter().copied();
        let sections: Vec<usize> = sections.filter(|&e| tree.elements[e].name == section).collect();
        let mut following = Vec::new();
        for &at in &sections {
            let children = core::mem::take(&mut tree.elements[at].children);
            let (with, without): (Vec<usize>, Vec<usize>) =
                children.into_iter().partition(|&child| refers(tree, child, &names));
            tree.elements[at].children = without;
            following.extend(with);
        }
        let Some(&last) = sections.last() else { continue };
        if section == "tendon" {
            let tendons = following.iter().filter_map(|&tendon| tree.elements[tendon].attribute("name"));
            names.extend(tendons.map(|name| ("tendon", name.to_string())).collect::<Vec<Named>>());
        }
        for suffix in suffixes {
            for &original in &following {
                let new = copy(tree, original, suffix)?;
                rename(tree, new, &names, suffix);
                tree.elements[last].children.push(new);
            }
        }
    }
    Ok(())
}

fn refers(tree: &Tree, element: usize, names: &BTreeSet<Named>) -> bool {
    let here = &tree.elements[element];
    let own = here.attributes.iter().any(|(attribute, value)| is_one(attribute, value, names));
    own || here.children.iter().any(|&child| refers(tree, child, names))
}

fn is_one(attribute: &str, value: &str, names: &BTreeSet<Named>) -> bool {
    kind_of(attribute).is_some_and(|kind| names.contains(&(kind, value.to_string())))
}

/// Adds the suffix to every reference to one of the names.
fn rename(tree: &mut Tree, element: usize, names: &BTreeSet<Named>, suffix: &str) {
    let mut open = Vec::from([element]);
    while let Some(at) = open.pop() {
        let here = &mut tree.elements[at];
        let references =
            here.attributes.iter_mut().filter(|(attribute, value)| is_one(attribute, value, names));
        references.for_each(|(_, value)| value.push_str(suffix));
        open.extend(&here.children);
    }
}
