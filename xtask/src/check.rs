//! The steps of `cargo xtask check`, in the order in which a mistake is found soonest.

use crate::{hygiene, layering, page, passed, python, readme, test_programs, tree};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::Instant;

/// One step: a name to type, what it is for, what it does.
pub(crate) struct Step {
    name: &'static str,
    purpose: &'static str,
    run: fn(&Path, &Turn) -> Result<(), String>,
}

/// While it is a step's turn, the next step waits.
pub(crate) struct Turn(Sender<()>);

impl Turn {
    /// The next step begins, beside what this one still has to do.
    pub(crate) fn end(&self) {
        // Nobody waits for the end of a turn that is over.
        let _ = self.0.send(());
    }
}

/// All steps. Every build uses the dev profile and all features, so that each dependency is compiled once.
const STEPS: [Step; 10] = [
    Step { name: "fmt", purpose: "the code is formatted", run: |root, _| fmt(root) },
    Step {
        name: "hygiene",
        purpose: "no huge files, stubs, conflict markers, private paths or retired words",
        run: |root, _| hygiene::check(root),
    },
    Step {
        name: "layering",
        purpose: "no room imports what it must not know, no circle between files",
        run: |root, _| layering::check(root),
    },
    Step {
        name: "clippy",
        purpose: "no warning with all features, tests, examples and benches",
        run: |root, _| clippy(root),
    },
    Step {
        name: "test",
        purpose: "unit and integration tests (nextest where installed)",
        run: test_programs::run,
    },
    Step {
        name: "readme",
        purpose: "the README's commands run, its usage is the program's",
        run: readme::check,
    },
    Step { name: "features", purpose: "no warning without optional features", run: |root, _| features(root) },
    Step { name: "doctest", purpose: "the examples in the documentation", run: |root, _| doctest(root) },
    Step { name: "doc", purpose: "the documentation builds without a warning", run: |root, _| doc(root) },
    Step { name: "examples", purpose: "the examples run to their end", run: |root, _| examples(root) },
];

/// Left to `cargo xtask check --long`: statistics over many seeds, minutes of them.
const LONG: Step = Step {
    name: "long",
    purpose: "statistical tests over many seeds, every bench once",
    run: |root, _| long(root),
};

/// Left to `cargo xtask check python`: it needs an interpreter, and packages that it installs into `target`.
const PYTHON: Step = Step {
    name: "python",
    purpose: "the Python package: types, tests, documentation",
    run: |root, _| python::check(root),
};

/// Left to `cargo xtask check page`: it needs a browser, and packages that it installs into `target`.
const PAGE: Step = Step {
    name: "page",
    purpose: "the live page in a headless Chromium, types of its scripts",
    run: |root, _| page::check(root),
};

/// The steps with their purpose, one a line.
pub(crate) fn list() -> String {
    let lines = STEPS.iter().chain([&LONG, &PYTHON, &PAGE]).map(|s| format!("{:<12}{}", s.name, s.purpose));
    lines.collect::<Vec<_>>().join("\n")
}

/// The named steps in the order of [`STEPS`]; all of them, and [`LONG`] if `--long` stands there, where none is named.
/// [`PYTHON`] and [`PAGE`] run only by their names. With `--again`, what has passed as it is runs, too.
pub(crate) fn chosen(names: &[&str]) -> Result<Vec<&'static Step>, String> {
    let (flags, names): (Vec<&str>, Vec<&str>) = names.iter().partition(|name| FLAGS.contains(name));
    let all = || STEPS.iter().chain([&LONG, &PYTHON, &PAGE]);
    if let Some(unknown) = names.iter().find(|name| all().all(|step| step.name != **name)) {
        let known: Vec<&str> = all().map(|step| step.name).collect();
        return Err(format!("`{unknown}` is not a step; expected one of {}", known.join(", ")));
    }
    let wanted = |step: &&Step| match step.name {
        name if names.contains(&name) => true,
        "long" => flags.contains(&"--long"),
        "python" | "page" => false,
        _ => names.is_empty(),
    };
    if flags.contains(&"--again") {
        passed::forget(&tree::root())?;
    }
    Ok(all().filter(wanted).collect())
}

const FLAGS: [&str; 2] = ["--long", "--again"];

/// Runs the steps up to the first that fails, and prints how long each took.
pub(crate) fn run(steps: &[&Step]) -> ExitCode {
    let began = Instant::now();
    let failed = AtomicBool::new(false);
    let run = |step: &Step, turn: &Turn| {
        let began = Instant::now();
        let outcome = (step.run)(&tree::root(), turn);
        failed.fetch_or(outcome.is_err(), Ordering::Relaxed);
        turn.end();
        (step.name, began.elapsed().as_secs_f64(), outcome)
    };
    let ran: Vec<_> = std::thread::scope(|scope| {
        let mut begun = Vec::new();
        for (number, step) in steps.iter().enumerate() {
            println!("[{}/{}] {}: {}", number + 1, steps.len(), step.name, step.purpose);
            let (turn, next) = channel();
            let run = &run;
            begun.push((step.name, scope.spawn(move || run(step, &Turn(turn)))));
            // An error where its thread has panicked.
            let panicked = next.recv().is_err();
            if panicked || failed.load(Ordering::Relaxed) {
                break;
            }
        }
        let panicked = |name| (name, 0.0, Err("its thread panicked".to_owned()));
        begun.into_iter().map(|(name, thread)| thread.join().unwrap_or_else(|_| panicked(name))).collect()
    });
    let mut times: Vec<(&str, f64)> = ran.iter().map(|(name, seconds, _)| (*name, *seconds)).collect();
    times.push(("all", began.elapsed().as_secs_f64()));
    let failed: Vec<_> =
        ran.iter().filter_map(|(name, _, outcome)| Some((name, outcome.as_ref().err()?))).collect();
    for (name, message) in &failed {
        eprintln!("error: {message}");
        println!("{name} FAILED; again with: cargo xtask check {name}");
    }
    println!("{}", table(&times));
    println!("{} passed, {} failed", ran.len() - failed.len(), failed.len());
    if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Seconds of every step and of all.
fn table(times: &[(&str, f64)]) -> String {
    let row = |(name, seconds): &(&str, f64)| format!("{name:<12}{seconds:>8.1} s");
    times.iter().map(row).collect::<Vec<_>>().join("\n")
}

/// The judge of mutants, a workspace of its own.
pub(crate) const MUTANTS: &str = "xtask/mutants/Cargo.toml";

/// The cargo that runs this program, in the root of the workspace.
pub(crate) fn cargo(root: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(arguments);
    for (name, value) in SETTINGS {
        if std::env::var_os(name).is_none() {
            command.env(name, value);
        }
    }
    command
}

/// A check from nothing gains nothing from incremental compilation, and messages of panics name file and line without debugging
/// information.
const SETTINGS: [(&str, &str); 2] = [("CARGO_INCREMENTAL", "0"), ("CARGO_PROFILE_DEV_DEBUG", "0")];

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
    let in_workspace = |manifest: Option<&str>| {
        let of = manifest.map(|manifest| ["--manifest-path", manifest]);
        let mut command = cargo(root, &["fmt", "--all", "--check"]);
        succeed(command.args(of.into_iter().flatten()))
    };
    std::thread::scope(|scope| {
        let others = [page::MANIFEST, MUTANTS].map(|manifest| scope.spawn(|| in_workspace(Some(manifest))));
        let own = in_workspace(None);
        let others = others.map(|thread| thread.join().unwrap_or_else(|_| Err("cargo fmt panicked".into())));
        others.into_iter().fold(own, Result::and)
    })
}

fn clippy(root: &Path) -> Result<(), String> {
    let mut command = cargo(root, &["clippy", "--workspace", "--all-targets", "--all-features", "--"]);
    succeed(command.args(LINTS))
}

/// Of clippy.
const LINTS: [&str; 2] = ["-D", "warnings"];

/// Environment in which cargo takes the metadata of the workspace's crates that [`clippy`] has written for its own, as `cargo clippy`
/// sets it; empty where clippy is not beside cargo. Where another version of it sets another, the crates are checked again.
fn as_clippy() -> Vec<(&'static str, OsString)> {
    let cargo = std::env::var_os("CARGO").map(PathBuf::from).unwrap_or_default();
    let driver = cargo.with_file_name(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    if !driver.is_file() {
        return Vec::new();
    }
    let arguments = LINTS.map(|argument| format!("{argument}__CLIPPY_HACKERY__")).concat();
    vec![("RUSTC_WORKSPACE_WRAPPER", driver.into()), ("CLIPPY_ARGS", arguments.into())]
}

/// What is built without optional features: the program as it is installed, the core as a microcontroller takes it.
fn features(root: &Path) -> Result<(), String> {
    for packages in FEATURE_SETS {
        let mut command = cargo(root, &["clippy"]);
        succeed(command.args(packages).arg("--").args(LINTS))?;
    }
    Ok(())
}

/// Beside the program stands a package that gives its dependencies the features that they have in the whole workspace, so that they are
/// not checked again.
const FEATURE_SETS: [&[&str]; 2] = [
    &["--package", "sinew-cli", "--package", "sinew-dependencies"],
    &["--package", "sinew", "--package", "sinew-dependencies", "--no-default-features"],
];

/// Of libraries: a change of the program leaves them as they are.
fn doctest(root: &Path) -> Result<(), String> {
    let now = passed::state_of_libraries(root)?;
    passed::unless(root, "doctest", now, || {
        succeed(&mut cargo(root, &["test", "--quiet", "--workspace", "--all-features", "--doc"]))
    })
}

/// rustdoc needs the metadata of all crates: that of [`clippy`] serves, so that nothing is checked again.
fn doc(root: &Path) -> Result<(), String> {
    let mut command = cargo(root, &["doc", "--quiet", "--workspace", "--all-features", "--no-deps"]);
    succeed(command.env("RUSTDOCFLAGS", "-Dwarnings").envs(as_clippy()))
}

/// Runs every example of `crates/sinew` and `crates/sinew-lab`: the files there are the list, the programs are those of the whole
/// workspace, because a package built alone has other features and is compiled anew. Benches are run by [`long`].
fn examples(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["build", "--quiet", "--workspace", "--all-features", "--examples"]))?;
    let data = passed::state_of_data(root)?;
    for package in ["sinew", "sinew-lab"] {
        for (file, _) in tree::sources(root, &format!("crates/{package}/examples"))? {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            let program = target(root).join(format!("debug/examples/{name}{}", std::env::consts::EXE_SUFFIX));
            let now = passed::state_of_program(root, &program, &data)?;
            passed::unless(root, &format!("example {name}"), now, || {
                succeed(Command::new(&program).current_dir(root).stdout(Stdio::null()))
            })?;
        }
    }
    Ok(())
}

/// Where cargo builds.
pub(crate) fn target(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(folder))
}

/// Tests whose names begin with `long_` do their work only where `SINEW_LONG` is set.
fn long(root: &Path) -> Result<(), String> {
    let arguments = [
        "test",
        "--workspace",
        "--all-features",
        "--tests",
        "--",
        "--nocapture",
        "--test-threads",
        "2",
        "long_",
    ];
    succeed(cargo(root, &arguments).env("SINEW_LONG", "1"))?;
    // Every bench once, without measuring.
    succeed(&mut cargo(root, &["bench", "--workspace", "--all-features", "--benches", "--", "--test"]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn named_steps_run_in_the_order_of_the_list_and_an_unknown_one_is_refused() {
        let steps = chosen(&["clippy", "fmt"]).unwrap();
        assert_eq!(steps.iter().map(|s| s.name).collect::<Vec<_>>(), ["fmt", "clippy"]);
        assert_eq!(chosen(&[]).unwrap().len(), STEPS.len());
        assert_eq!(chosen(&["--long"]).unwrap().len(), STEPS.len() + 1);
        assert_eq!(chosen(&["long"]).unwrap().len(), 1);
        assert_eq!(chosen(&["python"]).unwrap().len(), 1);
        assert_eq!(chosen(&["page"]).unwrap().len(), 1);
        let refused = chosen(&["fmt", "clipy"]).err().unwrap();
        assert!(refused.contains("`clipy`") && refused.contains("clippy"), "{refused}");
    }

    #[test]
    fn a_step_begins_where_the_turn_before_has_ended_and_none_after_a_failure() {
        static BEGUN: Mutex<Vec<&str>> = Mutex::new(Vec::new());
        let first = Step {
            name: "first",
            purpose: "ends its turn and runs on until the second has begun",
            run: |_, turn| {
                BEGUN.lock().unwrap().push("first");
                turn.end();
                let patience = Instant::now();
                while !BEGUN.lock().unwrap().contains(&"second") && patience.elapsed().as_secs() < 20 {
                    std::thread::yield_now();
                }
                let mut begun = BEGUN.lock().unwrap();
                if begun.contains(&"second") {
                    begun.push("first has seen the second");
                }
                Ok(())
            },
        };
        let second = Step {
            name: "second",
            purpose: "fails",
            run: |_, _| {
                BEGUN.lock().unwrap().push("second");
                Err("as it should".into())
            },
        };
        let third = Step {
            name: "third",
            purpose: "never begins",
            run: |_, _| {
                BEGUN.lock().unwrap().push("third");
                Ok(())
            },
        };
        let outcome = run(&[&first, &second, &third]);
        assert_eq!(format!("{outcome:?}"), format!("{:?}", ExitCode::FAILURE));
        assert_eq!(*BEGUN.lock().unwrap(), ["first", "second", "first has seen the second"]);
    }

    #[test]
    fn a_failing_command_is_named_with_its_outcome() {
        let root = tree::root();
        let message = succeed(cargo(&root, &["no-such-subcommand"]).stderr(Stdio::null()));
        assert!(message.unwrap_err().contains("no-such-subcommand"));
    }
}
