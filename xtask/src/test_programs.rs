//! Unit and integration tests. Each group is built while the tests of the group before run, and a program of tests runs only where it, or a
//! file of the project that is no Rust source, has changed since it passed.

use crate::check::{Turn, cargo, succeed, target};
use crate::passed::{Passed, folder, state, state_of_data};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// What cargo builds for the groups. The two packages that are optimised for the tests of all others are apart: their unit tests run for
/// seconds, and to optimise them would take a minute and half a minute. What takes long without is an integration test there. Their unit
/// tests are two groups: built together, those of `sinew-identify` would link an unoptimised `sinew`. `sinew-dependencies` gives both the
/// dependencies that the others have left.
const GROUPS: [(&str, &[&str]); 4] = [
    ("others", &OTHERS),
    (
        "optimised",
        &[
            "--package=sinew",
            "--package=sinew-identify",
            "--package=sinew-dependencies",
            "--all-features",
            "--test=*",
        ],
    ),
    (
        "sinew-units",
        &[
            "--package=sinew",
            "--package=sinew-dependencies",
            "--all-features",
            "--lib",
            "--config=profile.dev.package.sinew.opt-level=0",
        ],
    ),
    (
        "identify-units",
        &[
            "--package=sinew-identify",
            "--package=sinew-dependencies",
            "--all-features",
            "--lib",
            "--config=profile.dev.package.sinew-identify.opt-level=0",
        ],
    ),
];

/// The first group. The program is a part of its build.
pub(crate) const OTHERS: [&str; 5] =
    ["--workspace", "--exclude=sinew", "--exclude=sinew-identify", "--all-features", "--tests"];

/// The package whose tests start the program.
const OF_PROGRAM: &str = "sinew-cli";
/// The package whose tests read the sources of all others: they run every time.
const OF_SOURCES: &str = "xtask";

/// Builds all groups and runs what has not passed as it is. The turn ends where the last group with such programs begins to run: builds and
/// tests beside further steps would take each other's caches.
pub(crate) fn run(root: &Path, turn: &Turn) -> Result<(), String> {
    let nextest = cargo(root, &["nextest", "--version"]).output().is_ok_and(|output| output.status.success());
    if !nextest {
        println!("cargo-nextest is not installed: running `cargo test`");
        let test =
            |(_, selection): &(&str, &[&str])| succeed(cargo(root, &["test", "--quiet"]).args(*selection));
        return GROUPS.iter().try_for_each(test);
    }
    let folder = folder(root);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let metadata = folder.join("metadata.json");
    write_output(&mut cargo(root, &["metadata", "--format-version=1", "--all-features"]), &metadata)?;
    let passed = Passed::of(root);
    let files = state_of_data(root)?;
    let (sender, groups) = channel();
    let (not_begun, all_built) = (AtomicUsize::new(0), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let builder = scope.spawn(|| {
            // Moved, so that the groups end with the builds.
            let sender = sender;
            for (name, selection) in GROUPS {
                let list = folder.join(name).with_extension("json");
                let mut command =
                    cargo(root, &["nextest", "list", "--cargo-quiet", "--list-type=binaries-only"]);
                write_output(command.arg("--message-format=json-pretty").args(selection), &list)?;
                let programs = to_run(root, &list, &files, &passed)?;
                if programs.is_empty() {
                    continue;
                }
                not_begun.fetch_add(1, Ordering::SeqCst);
                if sender.send((list, programs)).is_err() {
                    // A test of an earlier group has failed.
                    return Ok(());
                }
            }
            all_built.store(true, Ordering::SeqCst);
            if not_begun.load(Ordering::SeqCst) == 0 {
                turn.end();
            }
            Ok(())
        });
        let ran = groups.into_iter().try_for_each(|(list, programs)| {
            if not_begun.fetch_sub(1, Ordering::SeqCst) == 1 && all_built.load(Ordering::SeqCst) {
                turn.end();
            }
            let chosen =
                programs.keys().map(|id| format!("binary_id(={id})")).collect::<Vec<_>>().join(" + ");
            let mut command = cargo(root, &["nextest", "run", "--filterset", &chosen, "--binaries-metadata"]);
            succeed(command.arg(list).arg("--cargo-metadata").arg(&metadata))?;
            Passed::of(root).remember(programs)
        });
        let built = builder.join().unwrap_or_else(|_| Err("the build of the tests panicked".into()));
        built.and(ran)
    })
}

/// Programs of a built group that have not passed as they are, with their state.
fn to_run(
    root: &Path,
    list: &Path,
    files: &str,
    passed: &Passed,
) -> Result<BTreeMap<String, String>, String> {
    let text = std::fs::read_to_string(list).map_err(|e| format!("{}: {e}", list.display()))?;
    let mut programs = programs(&text);
    let all = programs.len();
    let program = target(root).join(format!("debug/sinew{}", std::env::consts::EXE_SUFFIX));
    for (id, path) in &mut programs {
        let program = id.starts_with(OF_PROGRAM).then(|| program.clone());
        let state = state(root, &[PathBuf::from(&*path)].into_iter().chain(program).collect::<Vec<_>>());
        *path = format!("{path} {state:x} {files}");
    }
    programs.retain(|id, now| id.starts_with(OF_SOURCES) || !passed.holds(id, now));
    if programs.len() < all {
        println!("{} programs of tests have passed as they are (`--again` runs them)", all - programs.len());
    }
    Ok(programs)
}

/// Names of the programs of tests in nextest's list, and where they are.
fn programs(list: &str) -> BTreeMap<String, String> {
    let values = |key: &str| {
        let start = format!("\"{key}\": \"");
        let value =
            move |line: &str| Some(line.trim().strip_prefix(&start)?.trim_end_matches([',', '"']).to_owned());
        list.lines().filter_map(value).collect::<Vec<_>>()
    };
    values("binary-id").into_iter().zip(values("binary-path")).collect()
}

/// Runs a command and keeps what it prints.
fn write_output(command: &mut Command, file: &Path) -> Result<(), String> {
    let output = std::fs::File::create(file).map_err(|e| format!("{}: {e}", file.display()))?;
    succeed(command.stdout(Stdio::from(output)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree;
    use std::collections::BTreeSet;

    #[test]
    fn packages_and_dependencies_have_the_same_features_in_every_group() {
        let root = tree::root();
        let features = |packages: &[&str]| -> BTreeSet<String> {
            let mut command =
                cargo(&root, &["tree", "--offline", "--color=never", "--all-features", "--prefix=none"]);
            let output = command
                .args(["--edges=normal,build,dev", "--format={p} [{f}]"])
                .args(packages)
                .output()
                .unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            let lines = text.lines().map(|line| line.trim_end_matches(" (*)").to_owned());
            lines.filter(|line| !line.is_empty()).collect()
        };
        let of_others = |all: &BTreeSet<String>| -> BTreeSet<String> {
            all.iter().filter(|line| !line.contains("(/")).cloned().collect()
        };
        let all = features(&["--workspace"]);
        for (name, selection) in GROUPS {
            let chooses = |argument: &&str| {
                ["--workspace", "--exclude", "--package"].iter().any(|a| argument.starts_with(a))
            };
            let group = features(&selection.iter().copied().filter(chooses).collect::<Vec<_>>());
            assert_eq!(of_others(&group), of_others(&all), "{name}");
            let own = group.difference(&all).collect::<Vec<_>>();
            assert!(own.is_empty(), "{name}: {own:?}");
        }
    }

    #[test]
    fn programs_are_read_from_the_list() {
        let list = r#"{
          "rust-binaries": {
            "a::b": {
              "binary-id": "a::b",
              "binary-path": "/target/b-1",
            },
            "c": {
              "binary-id": "c",
              "binary-path": "/target/c-2"
            }"#;
        let expected = [("a::b", "/target/b-1"), ("c", "/target/c-2")];
        assert_eq!(programs(list), expected.map(|(id, path)| (id.to_owned(), path.to_owned())).into());
    }
}
