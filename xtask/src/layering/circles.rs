//! Circles between the files of a crate, found from the paths that each file names.
//!
//! An arrow leads from a file to the file that defines a name it uses; a name that a module only re-exports
//! belongs to the file that defines it. `mod x;`, `pub use` and test modules make no arrows.

use super::paths::{Import, imports, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// One file of a crate: where its module stands below the crate's root, and what it names.
struct File {
    place: String,
    module: Vec<String>,
    imports: Vec<Import>,
}

/// Arrows: `from` -> `to` -> a name that ties them.
type Arrows = BTreeMap<usize, BTreeMap<usize, String>>;

/// Every circle in words, from the sources of one crate as (place below `src/`, text).
///
/// # Errors
/// Names the file that is no Rust.
pub(super) fn circles(sources: &[(String, String)]) -> Result<Vec<String>, String> {
    let file = |(place, text): &(String, String)| {
        let tokens = tokens(text).map_err(|error| format!("{place}: {error}"))?;
        Ok(File { place: place.clone(), module: module(place), imports: imports(&tokens) })
    };
    let files: Vec<File> =
        sources.iter().filter(|(place, _)| !is_test(place)).map(file).collect::<Result<_, String>>()?;
    let arrows = arrows(&files);
    let reached: Vec<BTreeSet<usize>> = (0..files.len()).map(|i| reach(&arrows, i)).collect();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for i in 0..files.len() {
        let circle: Vec<usize> = reached[i].iter().copied().filter(|j| reached[*j].contains(&i)).collect();
        if circle.is_empty() || !seen.insert(circle.clone()) {
            continue;
        }
        let ties = circle.iter().flat_map(|from| {
            let inside = arrows.get(from).into_iter().flatten().filter(|(to, _)| circle.contains(to));
            inside.map(|(to, name)| format!("{} -> {} ({name})", files[*from].place, files[*to].place))
        });
        found.push(format!("circle of imports: {}", ties.collect::<Vec<_>>().join(", ")));
    }
    Ok(found)
}

fn is_test(place: &str) -> bool {
    place.split('/').any(|part| part == "tests" || part == "tests.rs")
}

/// `lib.rs` and `main.rs` are the root; `a/mod.rs` is `a`; `a/b.rs` is `a::b`.
pub(super) fn module(place: &str) -> Vec<String> {
    let mut parts: Vec<String> = place.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        parts.pop();
    }
    parts
}

fn arrows(files: &[File]) -> Arrows {
    let modules: BTreeMap<&[String], usize> =
        files.iter().enumerate().map(|(i, file)| (file.module.as_slice(), i)).collect();
    let mut arrows = Arrows::new();
    for (from, file) in files.iter().enumerate() {
        // Modules that this file has imported by name: `use crate::body;` and then `body::Robot`.
        let named: BTreeMap<&str, Vec<String>> = file
            .imports
            .iter()
            .filter(|import| import.in_use)
            .filter_map(|import| Some((import.alias.as_str(), absolute(import, &file.module, &modules)?)))
            .filter(|(_, path)| modules.contains_key(path.as_slice()))
            .collect();
        for import in file.imports.iter().filter(|import| !import.public) {
            let path = absolute(import, &file.module, &modules).or_else(|| {
                let (first, rest) = import.path.split_first()?;
                let start = named.get(first.as_str()).filter(|_| !import.in_use)?;
                Some([start, rest].concat())
            });
            let Some(path) = path else { continue };
            let Some(to) = definition(&path, files, &modules, 0).filter(|to| *to != from) else { continue };
            // A module imported as such is tied by the names that are then taken from it.
            if !modules.contains_key(path.as_slice()) {
                let name = path.last().cloned().unwrap_or_default();
                arrows.entry(from).or_default().entry(to).or_insert(name);
            }
        }
    }
    arrows
}

/// A path from the crate's root, for one that is written from there, from a parent, or from a child module.
fn absolute(import: &Import, here: &[String], modules: &BTreeMap<&[String], usize>) -> Option<Vec<String>> {
    let (first, rest) = import.path.split_first()?;
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" => Some([here, rest].concat()),
        "super" => {
            let climbed = import.path.iter().take_while(|part| *part == "super").count();
            let kept = here.len().checked_sub(climbed)?;
            Some([&here[..kept], &import.path[climbed..]].concat())
        }
        _ => {
            let child = [here, std::slice::from_ref(first)].concat();
            modules.contains_key(child.as_slice()).then(|| [here, &import.path].concat())
        }
    }
}

/// The file that defines what a path from the root names.
fn definition(
    path: &[String],
    files: &[File],
    modules: &BTreeMap<&[String], usize>,
    hops: usize,
) -> Option<usize> {
    let depth = (0..=path.len()).rev().find(|n| modules.contains_key(&path[..*n]))?;
    let file = modules[&path[..depth]];
    let Some(name) = path.get(depth) else { return Some(file) };
    // A chain of re-exports is short; a longer one is a mistake of this reader.
    if hops > 8 {
        return None;
    }
    let passed_on = files[file].imports.iter().filter(|import| import.in_use && import.alias == *name);
    for import in passed_on {
        if let Some(from) = absolute(import, &files[file].module, modules) {
            let further = [&from, &path[depth + 1..]].concat();
            return definition(&further, files, modules, hops + 1);
        }
    }
    Some(file)
}

/// Every file that arrows lead to from one, itself only where they lead back.
fn reach(arrows: &Arrows, from: usize) -> BTreeSet<usize> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<usize> = arrows.get(&from).into_iter().flatten().map(|(to, _)| *to).collect();
    while let Some(next) = open.pop() {
        if reached.insert(next) {
            open.extend(arrows.get(&next).into_iter().flatten().map(|(to, _)| *to));
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(sources: &[(&str, &str)]) -> Vec<String> {
        let owned: Vec<_> = sources.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
        circles(&owned).unwrap()
    }

    #[test]
    fn two_files_that_name_each_other_are_a_circle_with_both_ties() {
        let circle = found(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "use crate::b::B; pub struct A(B);"),
            ("b.rs", "pub struct B; fn f(a: &super::a::A) {}"),
        ]);
        assert_eq!(circle.len(), 1);
        assert!(circle[0].contains("a.rs -> b.rs (B)") && circle[0].contains("b.rs -> a.rs (A)"));
    }

    #[test]
    fn a_name_belongs_to_the_file_that_defines_it_not_to_the_module_that_re_exports_it() {
        let none = [
            ("lib.rs", "pub mod room;"),
            ("room/mod.rs", "mod low; mod high; pub use low::Low; pub use high::High;"),
            ("room/low.rs", "pub struct Low;"),
            ("room/high.rs", "use super::Low; use crate::room; pub struct High(Low, room::Low);"),
        ];
        assert!(found(&none).is_empty(), "{:?}", found(&none));
    }

    #[test]
    fn a_child_that_uses_what_its_module_defines_with_the_child_is_in_a_circle() {
        let sources = [
            ("room/mod.rs", "mod part; use part::Part; pub struct Whole(Part);"),
            ("room/part.rs", "pub struct Part; fn f(whole: &super::Whole) {}"),
        ];
        assert_eq!(found(&sources).len(), 1);
    }

    #[test]
    fn tests_draw_no_arrows() {
        let sources = [
            ("a.rs", "pub struct A;\n#[cfg(test)]\nmod tests { use crate::b::B; }"),
            ("b.rs", "use crate::a::A; pub struct B(A);"),
            ("a/tests.rs", "use crate::b::B;"),
        ];
        assert!(found(&sources).is_empty());
    }

    #[test]
    fn a_longer_circle_through_an_imported_module_is_found_once() {
        let sources = [
            ("a.rs", "use crate::b; pub fn f() { b::g(); }"),
            ("b.rs", "use crate::c::{self, h}; pub fn g() { h(); }"),
            ("c.rs", "pub fn h() { crate::a::f(); }"),
        ];
        assert_eq!(found(&sources).len(), 1, "{:?}", found(&sources));
    }
}
