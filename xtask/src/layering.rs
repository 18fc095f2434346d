//! Which room may know which: read from the sources and manifests, held against two tables.

mod circles;
mod paths;

use crate::tree;
use std::path::Path;

/// What each crate may depend on, development and build included. The runtime never sees identify: 1 kHz
/// code cannot even name an optimiser.
const CRATES: &str = "
sinew-models:
sinew: sinew-models
sinew-identify: sinew
sinew-session: sinew sinew-models
sinew-export: sinew
sinew-lab: sinew sinew-identify sinew-models sinew-session sinew-view
sinew-view: sinew sinew-models
sinew-report: sinew sinew-identify sinew-lab sinew-models sinew-view
sinew-segment:
sinew-link:
sinew-live: sinew sinew-lab sinew-record sinew-runtime sinew-session sinew-view
sinew-runtime: sinew sinew-segment sinew-link sinew-session
sinew-record: sinew sinew-runtime sinew-session
sinew-ros: sinew sinew-link sinew-record sinew-runtime sinew-session
sinew-mujoco: sinew
sinew-gym: sinew sinew-models
sinew-cli: sinew sinew-export sinew-identify sinew-lab sinew-report sinew-segment sinew-link sinew-live \
sinew-models sinew-runtime sinew-record sinew-ros sinew-session sinew-view
sinew-py: sinew sinew-identify sinew-lab sinew-models sinew-report sinew-runtime sinew-mujoco sinew-gym
";

/// What each room of `sinew` may import. `twin` and `control` never meet, so that plant and controller cannot
/// share a secret.
const ROOMS: &str = "
dispatch:
error:
lanes: dispatch
math: error
metrics: error math
random:
trajectory: error math random muscle body
drive: dispatch error lanes math random transmission
transmission: dispatch error math
muscle: error lanes math body
body: dispatch error lanes math
predictor: error math transmission
compensator: error predictor transmission
machine: error random body drive muscle predictor trajectory transmission
description: error math drive transmission muscle body predictor trajectory machine
control: compensator dispatch random error math trajectory drive transmission muscle body predictor machine
twin: dispatch error lanes math random trajectory drive transmission muscle body machine
lib: dispatch error lanes math metrics random trajectory drive transmission muscle body predictor compensator \
machine description control twin
";

/// Parts of the standard library that physics has no business with.
const OUTSIDE_WORLD: [&str; 7] = ["env", "fs", "io", "net", "process", "thread", "time"];

/// Fails on every arrow that neither table allows.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let (arrows, wrong) = arrows(root)?;
    if wrong.is_empty() {
        println!("{arrows} arrows");
        return Ok(());
    }
    Err(wrong.join("\nerror: "))
}

/// How many arrows there are, and the forbidden ones in words.
fn arrows(root: &Path) -> Result<(usize, Vec<String>), String> {
    let (mut count, mut wrong) = (0, Vec::new());
    for (manifest, text) in manifests(root)? {
        let name = manifest.rsplit('/').nth(1).unwrap_or_default();
        let found = dependencies(&text);
        count += found.len();
        wrong.extend(found.iter().filter_map(|to| forbidden(CRATES, &manifest, name, to)));
        if allowed(CRATES, name).is_none() {
            wrong.push(format!("{manifest}: `{name}` is not in the table of crates"));
        }
    }
    for (file, text) in tree::sources(root, "crates/sinew/src")? {
        let place = file.to_string_lossy().replace('\\', "/");
        let inside = place.trim_start_matches("crates/sinew/src/");
        let room = inside.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        let tokens = paths::tokens(&text).map_err(|error| format!("{place}: {error}"))?;
        for to in paths::from_root(&tokens, circles::module(inside).len()) {
            count += 1;
            // Capitals are what the root re-exports: the error.
            let to = if to.starts_with(char::is_uppercase) { "error" } else { &to };
            wrong.extend(forbidden(ROOMS, &place, room, to));
        }
        let outside =
            paths::after(&tokens, "std").into_iter().filter(|part| OUTSIDE_WORLD.contains(&part.as_str()));
        wrong.extend(
            outside.map(|part| format!("{place}: `std::{part}` in a crate without I/O, clock and threads")),
        );
        if allowed(ROOMS, room).is_none() {
            wrong.push(format!("{place}: `{room}` is not in the table of rooms"));
        }
    }
    for (manifest, _) in manifests(root)? {
        let folder = manifest.replace("Cargo.toml", "src/");
        let inside = |file: &Path| file.to_string_lossy().replace('\\', "/").replace(&folder, "");
        let sources = tree::sources(root, &folder)?;
        let sources: Vec<_> = sources.into_iter().map(|(file, text)| (inside(&file), text)).collect();
        let circles = circles::circles(&sources).map_err(|error| format!("{folder}{error}"))?;
        wrong.extend(circles.into_iter().map(|circle| format!("{folder}: {circle}")));
    }
    Ok((count, wrong))
}

fn allowed<'a>(table: &'a str, from: &str) -> Option<Vec<&'a str>> {
    let mut rows = table.split('\n').filter_map(|row| row.split_once(':'));
    rows.find(|(name, _)| *name == from).map(|(_, to)| to.split_whitespace().collect())
}

fn forbidden(table: &str, place: &str, from: &str, to: &str) -> Option<String> {
    let may = allowed(table, from)?;
    let fine = from == to || may.contains(&to);
    (!fine).then(|| format!("{place}: `{from}` imports `{to}`; it may import: {}", may.join(" ")))
}

fn manifests(root: &Path) -> Result<Vec<(String, String)>, String> {
    let folder = root.join("crates");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut found = Vec::new();
    for entry in entries.flatten().filter(|entry| entry.path().join("Cargo.toml").is_file()) {
        let name = format!("crates/{}/Cargo.toml", entry.file_name().to_string_lossy());
        let text = std::fs::read_to_string(root.join(&name)).map_err(|e| format!("{name}: {e}"))?;
        found.push((name, text));
    }
    found.sort();
    Ok(found)
}

/// Our own crates among the dependencies of a manifest, of every kind.
fn dependencies(manifest: &str) -> Vec<String> {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '-';
    let names = manifest.lines().filter_map(|line| line.split(|c| !part(c)).next());
    names.filter(|name| allowed(CRATES, name).is_some()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_room_of_this_project_imports_what_it_must_not_know() {
        let (count, wrong) = arrows(&tree::root()).unwrap();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert!(count >= 15, "only {count} arrows were seen: the reader is blind");
    }

    #[test]
    fn an_arrow_between_plant_and_controller_is_refused_both_ways() {
        for (from, to) in [("twin", "control"), ("control", "twin"), ("transmission", "predictor")] {
            let refused = forbidden(ROOMS, "somewhere.rs", from, to).unwrap();
            assert!(refused.contains("somewhere.rs") && refused.contains(to), "{refused}");
        }
        assert_eq!(forbidden(ROOMS, "", "predictor", "transmission"), None);
    }

    #[test]
    fn dependencies_of_every_kind_are_seen() {
        let manifest = "[package]\nname = \"sinew\"\n[dependencies]\nsinew-identify.workspace = \
            true\n[dev-dependencies]\n\
                        sinew-lab = { path = \"../sinew-lab\" }";
        assert_eq!(dependencies(manifest), ["sinew-identify", "sinew-lab"]);
        assert!(forbidden(CRATES, "", "sinew-runtime", "sinew-identify").is_some());
        assert!(forbidden(CRATES, "", "sinew", "sinew-cli").is_some());
    }
}
