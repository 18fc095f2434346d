//! Mutants as cargo-mutants lists them.

use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// A change of the source, as `cargo mutants --list --json` describes it.
#[derive(Clone, Deserialize)]
pub(crate) struct Mutant {
    /// `file:line:column: what is replaced by what in which function`.
    pub name: String,
    pub file: String,
    pub genre: Genre,
    pub replacement: String,
    pub span: Span,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
pub(crate) enum Genre {
    /// A binary or an assigning operator becomes another one.
    BinaryOperator,
    /// An operator `-` or `!` is deleted.
    UnaryOperator,
    /// A function returns a constant.
    FnValue,
    /// A guard of a match arm becomes `true` or `false`.
    MatchArmGuard,
    /// A match arm before a wildcard is deleted.
    MatchArm,
    /// A field is taken from the base of a struct expression.
    StructField,
    /// A constant is a hundred times as large, or a hundredth; not of cargo-mutants.
    Constant,
}

#[derive(Clone, Copy, Deserialize)]
pub(crate) struct Span {
    pub start: Place,
}

/// Line and column, both from 1, the column in characters.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
pub(crate) struct Place {
    pub line: usize,
    pub column: usize,
}

/// All mutants of the files below `rooms`, relative to the repository's root.
pub(crate) fn list(root: &Path, rooms: &[String]) -> Result<Vec<Mutant>, String> {
    let mut command = Command::new("cargo");
    command.current_dir(root).args(["mutants", "--list", "--json"]);
    for room in rooms {
        command.args(["--file", &format!("{}/**", room.trim_end_matches('/'))]);
    }
    let output = command.output().map_err(|error| format!("cargo mutants: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!(
            "`cargo mutants --list` failed: {said}(`cargo install cargo-mutants` installs it)"
        ));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("the list of cargo mutants: {error}"))
}

/// Factors by which a constant is wrong.
const FACTORS: [&str; 2] = ["100.0", "0.01"];

/// Constants of type `f64` of these files, each a hundred times as large and a hundredth.
pub(crate) fn constants(root: &Path, files: &BTreeSet<String>) -> Result<Vec<Mutant>, String> {
    let mut mutants = Vec::new();
    for file in files {
        let path = root.join(file);
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let syntax = syn::parse_file(&text).map_err(|error| format!("{file}: {error}"))?;
        for item in syntax.items {
            let syn::Item::Const(constant) = item else { continue };
            if !matches!(&*constant.ty, syn::Type::Path(path) if path.path.is_ident("f64")) {
                continue;
            }
            let at = constant.ident.span().start();
            let place = Place { line: at.line, column: at.column + 1 };
            mutants.extend(FACTORS.map(|factor| Mutant {
                name: format!("{file}:{}:{}: {} times {factor}", place.line, place.column, constant.ident),
                file: file.clone(),
                genre: Genre::Constant,
                replacement: factor.to_string(),
                span: Span { start: place },
            }));
        }
    }
    Ok(mutants)
}
