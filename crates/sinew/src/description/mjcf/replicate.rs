//! `replicate`: copies are expanded, each in its own frame and with what refers to it, before other elements
//! are read.

use super::compiler::Compiler;
use super::place::{HERE, Place};
use super::replicate_references::{follow, names_within};
use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;
use crate::description::tree::{Element, Tree};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Largest number of elements that copies may add, which bounds memory.
const MOST: usize = 100_000;

/// Replaces every `replicate` by a frame with its copies: the first before the second, what stands in one
/// before it.
pub(super) fn expand(tree: &mut Tree, compiler: &Compiler) -> Result<(), DescriptionError> {
    let most = tree.elements.len() + MOST;
    let (mut backwards, mut open) = (Vec::new(), Vec::from([0]));
    while let Some(at) = open.pop() {
        backwards.push(at);
        open.extend(&tree.elements[at].children);
    }
    for index in backwards.into_iter().rev() {
        if tree.elements[index].name == "replicate" {
            copies(tree, index, most, compiler)?;
        }
    }
    Ok(())
}

fn copies(tree: &mut Tree, index: usize, most: usize, compiler: &Compiler) -> Result<(), DescriptionError> {
    let at = Attributes::own(tree, index);
    let text = at.required("count")?;
    let count = text.trim().parse::<usize>();
    let count = count.map_err(|_| {
        at.error("count", format!("is `{}`: expected a whole number of copies", shortened(text)))
    })?;
    let separator = at.text("sep").unwrap_or_default().to_string();
    let angles = at.array_or("euler", [0.0; 3])?.map(|angle| angle * compiler.radians);
    let offset = at.array_or("offset", [0.0; 3])?;
    if count.saturating_mul(within(tree, index)) > most.saturating_sub(tree.elements.len()) {
        return Err(at.error(
            "count",
            format!("is {count}: with all that it holds, copies are more than {MOST} elements"),
        ));
    }
    let names = names_within(tree, index);
    let inside = core::mem::take(&mut tree.elements[index].children);
    let digits = count.to_string().len();
    let suffixes: Vec<String> = (0..count).map(|copy| format!("{separator}{copy:0digits$}")).collect();
    let mut place = HERE;
    for (copy, suffix) in suffixes.iter().enumerate() {
        let frame = blank(tree, index, &place);
        for &child in &inside {
            let child = clone(tree, child, suffix);
            tree.elements[frame].children.push(child);
        }
        tree.elements[index].children.push(frame);
        // Multiples of the Euler angles, not of the rotation: these differ for more than one angle.
        let orientation = turn::euler(angles.map(|angle| angle * (copy + 1) as f64), compiler.sequence);
        place = Place { position: place.point(offset), orientation };
    }
    follow(tree, names, &suffixes, |tree, original, suffix| {
        if within(tree, original) > most.saturating_sub(tree.elements.len()) {
            let problem = format!("makes more than {MOST} elements with all that refers to them");
            return Err(tree.error(index, "count", problem));
        }
        Ok(clone(tree, original, suffix))
    })?;
    let all = &mut tree.elements[index];
    all.name = "frame".to_string();
    all.attributes.retain(|(name, _)| name == "childclass");
    Ok(())
}

/// Number of elements of one copy, including its frame.
fn within(tree: &Tree, index: usize) -> usize {
    let (mut count, mut open) = (0, Vec::from([index]));
    while let Some(at) = open.pop() {
        count += 1;
        open.extend(&tree.elements[at].children);
    }
    count
}

/// An empty frame with the position in the file of the `replicate`.
fn blank(tree: &mut Tree, index: usize, place: &Place) -> usize {
    let numbers = |values: &[f64]| values.iter().map(|x| format!("{x:?}")).collect::<Vec<String>>().join(" ");
    let attributes = Vec::from([
        ("pos".to_string(), numbers(&place.position)),
        ("quat".to_string(), numbers(&place.orientation)),
    ]);
    let Element { file, line, .. } = tree.elements[index];
    tree.elements.push(Element { name: "frame".to_string(), attributes, children: Vec::new(), file, line });
    tree.elements.len() - 1
}

/// A copy of an element and its subtree, its names with a suffix.
fn clone(tree: &mut Tree, original: usize, suffix: &str) -> usize {
    let first = tree.elements.len();
    let mut open = Vec::from([(original, None)]);
    while let Some((from, parent)) = open.pop() {
        let (index, source) = (tree.elements.len(), &tree.elements[from]);
        let mut copy = Element { children: Vec::new(), ..source.clone() };
        copy.attributes
            .iter_mut()
            .filter(|(name, _)| name == "name")
            .for_each(|(_, own)| own.push_str(suffix));
        if copy.name == "attach" {
            // For the names of what it attaches; of several `replicate` the innermost stands first.
            match copy.attributes.iter_mut().find(|(name, _)| name == "suffix") {
                Some((_, inner)) => inner.push_str(suffix),
                None => copy.attributes.push(("suffix".to_string(), suffix.to_string())),
            }
        }
        open.extend(source.children.iter().rev().map(|&child| (child, Some(index))));
        tree.elements.push(copy);
        if let Some(parent) = parent {
            let parent: &mut Element = &mut tree.elements[parent];
            parent.children.push(index);
        }
    }
    first
}
