//! The steps of `cargo xtask check`, in the order in which a mistake is found soonest.

use crate::{hygiene, layering, readme, tree};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

/// One step: a name to type, what it is for, what it does.
pub(crate) struct Step {
    name: &'static str,
    purpose: &'static str,
    run: fn(&Path) -> Result<(), String>,
}

/// All steps. Every build uses the dev profile and, except for one pass of clippy, all features, so that each
/// dependency is compiled once.
const STEPS: [Step; 11] = [
    Step { name: "fmt", purpose: "the code is formatted", run: fmt },
    Step {
        name: "hygiene",
        purpose: "no huge files, stubs, conflict markers or private paths",
        run: hygiene::check,
    },
    Step { name: "layering", purpose: "no room imports what it must not know", run: layering::check },
    Step { name: "clippy", purpose: "no warning with default features", run: clippy },
    Step { name: "clippy-all", purpose: "no warning with all features", run: clippy_all },
    Step { name: "test", purpose: "unit and integration tests (nextest where installed)", run: test },
    Step { name: "doctest", purpose: "the examples in the documentation", run: doctest },
    Step { name: "doc", purpose: "the documentation builds without a warning", run: doc },
    Step { name: "build", purpose: "examples and benches build", run: build },
    Step {
        name: "readme",
        purpose: "the README's commands run, its usage is the program's",
        run: readme::check,
    },
    Step { name: "fuzz", purpose: "the fuzz targets build", run: fuzz },
];

/// The steps with their purpose, one a line.
pub(crate) fn list() -> String {
    let lines: Vec<String> = STEPS.iter().map(|s| format!("{:<12}{}", s.name, s.purpose)).collect();
    lines.join("\n")
}

/// The named steps in the order of [`STEPS`]; all of them where none is named.
pub(crate) fn chosen(names: &[&str]) -> Result<Vec<&'static Step>, String> {
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let known: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        return Err(format!("`{unknown}` is not a step; expected one of {}", known.join(", ")));
    }
    Ok(STEPS.iter().filter(|step| names.is_empty() || names.contains(&step.name)).collect())
}

/// Runs the steps up to the first that fails.
pub(crate) fn run(steps: &[&Step]) -> ExitCode {
    let start = Instant::now();
    for (done, step) in steps.iter().enumerate() {
        println!("[{}/{}] {}: {}", done + 1, steps.len(), step.name, step.purpose);
        let began = Instant::now();
        let outcome = (step.run)(&tree::root());
        let seconds = began.elapsed().as_secs_f64();
        if let Err(message) = outcome {
            eprintln!("error: {message}");
            println!(
                "{} FAILED after {seconds:.1} s; again with: cargo xtask check {}",
                step.name, step.name
            );
            println!("{done} passed, 1 failed");
            return ExitCode::FAILURE;
        }
        println!("{} ok in {seconds:.1} s", step.name);
    }
    println!("all in {:.1} s", start.elapsed().as_secs_f64());
    println!("{} passed, 0 failed", steps.len());
    ExitCode::SUCCESS
}

/// The cargo that runs this program, in the root of the workspace.
pub(crate) fn cargo(root: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(arguments);
    command
}

/// Runs a command to its end and reports how it failed.
pub(crate) fn succeed(command: &mut Command) -> Result<(), String> {
    let shown = shown(command);
    let status = command.status().map_err(|e| format!("`{shown}` did not start: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{shown}` ended with {status}")) }
}

fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

fn fmt(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["fmt", "--all", "--check"]))?;
    if root.join("fuzz/Cargo.toml").is_file() {
        succeed(&mut cargo(root, &["fmt", "--manifest-path", "fuzz/Cargo.toml", "--all", "--check"]))?;
    }
    Ok(())
}

fn clippy(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

fn clippy_all(root: &Path) -> Result<(), String> {
    let arguments = ["clippy", "--workspace", "--all-targets", "--all-features", "--", "-D", "warnings"];
    succeed(&mut cargo(root, &arguments))
}

fn test(root: &Path) -> Result<(), String> {
    let nextest = cargo(root, &["nextest", "--version"]).output().is_ok_and(|output| output.status.success());
    if nextest {
        return succeed(&mut cargo(root, &["nextest", "run", "--workspace", "--all-features"]));
    }
    println!("cargo-nextest is not installed: running `cargo test`");
    succeed(&mut cargo(root, &["test", "--quiet", "--workspace", "--all-features", "--tests"]))
}

fn doctest(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["test", "--quiet", "--workspace", "--all-features", "--doc"]))
}

fn doc(root: &Path) -> Result<(), String> {
    let mut command = cargo(root, &["doc", "--quiet", "--workspace", "--all-features", "--no-deps"]);
    succeed(command.env("RUSTDOCFLAGS", "-Dwarnings"))
}

fn build(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["build", "--workspace", "--all-features", "--examples", "--bench", "*"]))
}

fn fuzz(root: &Path) -> Result<(), String> {
    if !root.join("fuzz/Cargo.toml").is_file() {
        println!("no fuzz targets yet");
        return Ok(());
    }
    // A check, not a build: linking needs a nightly toolchain's instrumentation. Naming a libFuzzer that is never
    // linked spares compiling it, and with it the need for a C++ compiler; the folder of its own keeps
    // `cargo fuzz` from noticing.
    let mut command = cargo(root, &["check", "--manifest-path", "fuzz/Cargo.toml", "--all"]);
    let command = command
        .args(["--target-dir", "target/fuzz-check"])
        .env("CUSTOM_LIBFUZZER_PATH", "unused/libfuzzer.a");
    succeed(command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_steps_run_in_the_order_of_the_list_and_an_unknown_one_is_refused() {
        let steps = chosen(&["clippy", "fmt"]).unwrap();
        assert_eq!(steps.iter().map(|s| s.name).collect::<Vec<_>>(), ["fmt", "clippy"]);
        assert_eq!(chosen(&[]).unwrap().len(), STEPS.len());
        let refused = chosen(&["fmt", "clipy"]).err().unwrap();
        assert!(refused.contains("`clipy`") && refused.contains("clippy"), "{refused}");
    }

    #[test]
    fn a_failing_command_is_named_with_its_outcome() {
        let root = tree::root();
        let message = succeed(cargo(&root, &["no-such-subcommand"]).stderr(std::process::Stdio::null()));
        assert!(message.unwrap_err().contains("no-such-subcommand"));
    }
}
