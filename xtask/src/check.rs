//! The steps of `cargo xtask check`, in the order in which a mistake is found soonest.

use crate::{book, commands, hygiene, layering, page, python, readme, release, targets, tree};
use commands::{cargo, succeed, target};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// One step: a name to type, what it is for, what it does.
struct Step {
    name: &'static str,
    purpose: &'static str,
    run: fn(&Path) -> Result<(), String>,
    /// Whether it runs where no step is named.
    default: bool,
}

const fn step(name: &'static str, purpose: &'static str, run: fn(&Path) -> Result<(), String>) -> Step {
    Step { name, purpose, run, default: true }
}

const fn by_name(name: &'static str, purpose: &'static str, run: fn(&Path) -> Result<(), String>) -> Step {
    Step { name, purpose, run, default: false }
}

/// All steps. Every build uses the dev profile and all features, so that each dependency is compiled once.
const STEPS: [Step; 18] = [
    step("fmt", "the code is formatted", fmt),
    step(
        "hygiene",
        "no huge files, stubs, conflict markers, private paths, retired or misspelt words",
        hygiene::check,
    ),
    step("layering", "no room imports what it must not know, no circle between files", layering::check),
    step("book", "links and chapters of the texts hold; the book where mdbook is installed", book::check),
    step("clippy", "no warning with all features, tests, examples and benches", clippy),
    step("test", "unit and integration tests (nextest where installed)", test),
    step(
        "readme",
        "commands of README, tutorials and exports run, the list of verbs is the program's",
        readme::check,
    ),
    step("doctest", "the examples in the documentation", doctest),
    step("features", "no warning without optional features", features),
    step("targets", "the core has no dependency that a microcontroller refuses", targets::check),
    step("doc", "the documentation builds without a warning", doc),
    step("examples", "the examples run to their end", examples),
    by_name("long", "statistical tests over many seeds, every bench once", long),
    by_name("python", "the Python package: types, tests, documentation", python::check),
    by_name("batch", "MJX and MuJoCo Warp: long tests, oldest and newest versions", python::batch),
    by_name("guest", "CAN interfaces, in user-mode Linux with vcan", guest),
    by_name(
        "packages",
        "licences, sources and advisories of dependencies; crates as published",
        release::packages,
    ),
    by_name("page", "the live page in a headless Chromium, types of its scripts", page::check),
];

/// The steps with their purpose, one a line.
pub(crate) fn list() -> String {
    STEPS.iter().map(|step| format!("{:<12}{}", step.name, step.purpose)).collect::<Vec<_>>().join("\n")
}

/// Runs the named steps, or those by default, in the order of [`STEPS`] up to the first that fails, and
/// prints how long each took.
///
/// # Errors
/// For a name that is none of a step.
pub(crate) fn run(names: &[&str]) -> Result<ExitCode, String> {
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let known = STEPS.map(|step| step.name).join(", ");
        return Err(format!("`{unknown}` is not a step; expected one of {known}"));
    }
    let chosen = |step: &&Step| names.contains(&step.name) || (names.is_empty() && step.default);
    let steps: Vec<_> = STEPS.iter().filter(chosen).collect();
    let (began, mut times) = (Instant::now(), String::new());
    for (number, step) in steps.iter().enumerate() {
        println!("[{}/{}] {}: {}", number + 1, steps.len(), step.name, step.purpose);
        let begins = Instant::now();
        let outcome = (step.run)(&tree::root());
        times += &format!("{:<12}{:>8.1} s\n", step.name, begins.elapsed().as_secs_f64());
        if let Err(message) = outcome {
            eprintln!("error: {message}");
            println!("{times}{} FAILED; again with: cargo xtask check {}", step.name, step.name);
            return Ok(ExitCode::FAILURE);
        }
    }
    println!("{times}{:<12}{:>8.1} s\n{} passed", "all", began.elapsed().as_secs_f64(), steps.len());
    Ok(ExitCode::SUCCESS)
}

fn fmt(root: &Path) -> Result<(), String> {
    let format = ["fmt", "--all", "--check"];
    succeed(&mut cargo(root, &format))?;
    succeed(cargo(root, &format).args(["--manifest-path", page::MANIFEST]))
}

const LINTS: [&str; 3] = ["--", "-D", "warnings"];

fn clippy(root: &Path) -> Result<(), String> {
    let all = ["clippy", "--workspace", "--all-targets", "--all-features"];
    succeed(cargo(root, &all).args(LINTS))
}

/// The program is among what is built, as a part of its tests.
fn test(root: &Path) -> Result<(), String> {
    let nextest = cargo(root, &["nextest", "--version"]).output().is_ok_and(|output| output.status.success());
    if nextest {
        return succeed(&mut cargo(root, &["nextest", "run", "--workspace", "--all-features"]));
    }
    println!("cargo-nextest is not installed: running `cargo test`");
    // A test runs an example as a program, which `cargo test --examples` does not build.
    succeed(&mut cargo(root, &["build", "--quiet", "--workspace", "--all-features", "--examples"]))?;
    let kinds = ["test", "--quiet", "--workspace", "--all-features", "--lib", "--bins", "--tests"];
    succeed(&mut cargo(root, &kinds))
}

/// What is built without optional features: the program as it is installed, the core as a microcontroller
/// takes it.
fn features(root: &Path) -> Result<(), String> {
    // With the tests that ask for features, whose dependencies have those of the other steps: none is
    // compiled twice.
    let parts = ["--lib", "--bins", "--test", "cli", "--test", "identify", "--test", "live"];
    succeed(cargo(root, &["clippy", "--workspace"]).args(parts).args(LINTS))?;
    succeed(cargo(root, &["clippy", "--package", "sinew", "--no-default-features"]).args(LINTS))
}

fn doctest(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["test", "--quiet", "--workspace", "--all-features", "--doc"]))
}

fn doc(root: &Path) -> Result<(), String> {
    let mut command = cargo(root, &["doc", "--quiet", "--workspace", "--all-features", "--no-deps"]);
    succeed(command.env("RUSTDOCFLAGS", "-Dwarnings"))
}

/// Every example that ends by itself. Built with the whole workspace, because a package alone has other
/// features and is compiled anew.
fn examples(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["build", "--quiet", "--workspace", "--all-features", "--examples"]))?;
    for package in ["sinew", "sinew-lab"] {
        for (file, _) in tree::sources(root, &format!("crates/{package}/examples"))? {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            let program = target(root).join(format!("debug/examples/{name}{}", std::env::consts::EXE_SUFFIX));
            succeed(Command::new(&program).current_dir(root).stdout(Stdio::null()))?;
        }
    }
    Ok(())
}

/// A kernel with CAN, which that of this machine need not have.
fn guest(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["build", "--quiet", "--workspace", "--all-features", "--bin", "sinew"]))?;
    let paths = [target(root).join("debug/sinew"), root.join("models")];
    succeed(Command::new(root.join(".ci/guest")).args(paths).current_dir(root))
}

/// Tests whose names begin with `long_` do their work only where `SINEW_LONG` is set.
fn long(root: &Path) -> Result<(), String> {
    let tests = [
        "test",
        "--workspace",
        "--all-features",
        "--tests",
        "--",
        "--nocapture",
        "--test-threads=2",
        "long_",
    ];
    succeed(cargo(root, &tests).env("SINEW_LONG", "1"))?;
    // Every bench once, without measuring.
    succeed(&mut cargo(root, &["bench", "--workspace", "--all-features", "--benches", "--", "--test"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_step_is_refused_with_those_that_are_known() {
        let refused = run(&["fmt", "clipy"]).unwrap_err();
        assert!(refused.contains("`clipy`") && refused.contains("clippy"), "{refused}");
    }
}
