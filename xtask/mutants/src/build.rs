//! The instrumented copy of the repository, and the programs of its tests.

use crate::instrument::{Instrumented, instrument};
use crate::mutant::Mutant;
use serde_json::Value;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Crate whose mutants are judged, by its own tests.
pub(crate) const CRATE: &str = "sinew";

/// Result of instrumentation: mutants that can be switched, and those that do not compile.
pub(crate) struct Build {
    pub switched: HashSet<usize>,
    pub unviable: HashSet<usize>,
    /// Programs of the unit tests and of the integration tests.
    pub programs: Vec<PathBuf>,
}

/// Copies the repository at `root` to `tree`, writes the mutants into it and builds its tests.
pub(crate) fn build(root: &Path, tree: &Path, mutants: &[Mutant], lib: bool) -> Result<Build, String> {
    copy(root, tree)?;
    let library = tree.join("crates").join(CRATE).join("src/lib.rs");
    let text = read(&library)? + "\n#[doc(hidden)]\n#[allow(missing_docs)]\npub mod mutants;\n";
    write(&library, &text)?;
    write(&library.with_file_name("mutants.rs"), include_str!("switch.rs"))?;

    let mut files: BTreeMap<&str, Vec<(usize, &Mutant)>> = BTreeMap::new();
    for (index, mutant) in mutants.iter().enumerate() {
        files.entry(&mutant.file).or_default().push((index + 1, mutant));
    }
    let mut unviable = HashSet::new();
    loop {
        let (mut switched, mut texts) = (HashSet::new(), BTreeMap::new());
        for (file, mutants) in &files {
            let Instrumented { text, switched: numbers } =
                instrument(&read(&root.join(file))?, mutants, &unviable)
                    .map_err(|error| format!("{file}: {error}"))?;
            write(&tree.join(file), &text)?;
            switched.extend(numbers);
            texts.insert(*file, text);
        }
        let refused = refused(tree, &texts)?;
        if refused.is_empty() {
            return Ok(Build { switched, unviable, programs: programs(tree, lib)? });
        }
        println!("{} mutants do not compile", refused.len());
        unviable.extend(refused);
    }
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Leaves a file that is as it shall be, so that cargo does not build it again.
fn write(path: &Path, text: &str) -> Result<(), String> {
    if std::fs::read(path).is_ok_and(|present| present == text.as_bytes()) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

fn copy(root: &Path, tree: &Path) -> Result<(), String> {
    // What the repository has no more must not be built; what cargo has built stays.
    for entry in
        std::fs::read_dir(tree).into_iter().flatten().flatten().filter(|entry| entry.file_name() != "target")
    {
        let path = entry.path();
        let removed =
            if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        removed.map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let output = Command::new("git")
        .current_dir(root)
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .output()
        .map_err(|error| format!("git ls-files: {error}"))?;
    for name in String::from_utf8_lossy(&output.stdout).split('\0').filter(|name| !name.is_empty()) {
        let (from, to) = (root.join(name), tree.join(name));
        let Ok(bytes) = std::fs::read(&from) else { continue };
        let folder = to.parent().unwrap_or(tree);
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        std::fs::write(&to, bytes).map_err(|error| format!("{}: {error}", to.display()))?;
    }
    Ok(())
}

fn cargo(tree: &Path, arguments: &[&str]) -> Result<(bool, Vec<Value>), String> {
    let output = Command::new("cargo")
        .current_dir(tree)
        .args(arguments)
        .args(["--package", CRATE, "--message-format=json"])
        .env("CARGO_TARGET_DIR", tree.join("target"))
        .env("CARGO_INCREMENTAL", "0")
        .env("RUSTFLAGS", "--cap-lints=allow")
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cargo: {error}"))?;
    let messages = String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect();
    Ok((output.status.success(), messages))
}

/// Numbers of the mutants that the compiler refuses. Empty where the crate compiles.
fn refused(tree: &Path, texts: &BTreeMap<&str, String>) -> Result<HashSet<usize>, String> {
    let (success, messages) = cargo(tree, &["check", "--quiet", "--lib"])?;
    if success {
        return Ok(HashSet::new());
    }
    let (mut refused, mut unexplained) = (HashSet::new(), Vec::new());
    for message in
        messages.iter().map(|message| &message["message"]).filter(|message| message["level"] == "error")
    {
        let rendered = message["rendered"].as_str().unwrap_or_default();
        // The rendered place is that in the crate, also where the error is inside a macro of another.
        let found =
            rendered.lines().find_map(|line| line.trim_start().strip_prefix("--> ")).and_then(|place| {
                let mut parts = place.split(':');
                mutant_at(texts.get(parts.next()?)?, parts.next()?.parse().ok()?)
            });
        if found.is_none() {
            unexplained.push(rendered);
        }
        refused.extend(found);
    }
    if refused.is_empty() {
        return Err(format!("the instrumented crate does not compile:\n{}", unexplained.join("\n")));
    }
    Ok(refused)
}

/// The mutant in whose arm a line (from 1) stands, or the first of the nearest place before it.
fn mutant_at(text: &str, line: usize) -> Option<usize> {
    let before: Vec<&str> = text.lines().take(line).collect();
    before.iter().rev().find_map(|line| {
        let (_, rest) = line.split_once("/*mutant*/ ")?;
        rest.split_once(' ')?.0.parse().ok()
    })
}

fn programs(tree: &Path, lib: bool) -> Result<Vec<PathBuf>, String> {
    let which: &[&str] = if lib { &["--lib"] } else { &["--lib", "--tests"] };
    let (success, messages) = cargo(tree, &[&["test", "--no-run"], which].concat())?;
    if !success {
        let said: Vec<_> =
            messages.iter().filter_map(|message| message["message"]["rendered"].as_str()).collect();
        return Err(format!("the instrumented tests do not compile:\n{}", said.join("\n")));
    }
    Ok(messages
        .iter()
        .filter(|message| message["profile"]["test"] == true)
        .filter_map(|message| message["executable"].as_str().map(PathBuf::from))
        .collect())
}
