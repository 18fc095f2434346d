//! What has passed in an earlier run, and in which state.

use crate::check::{cargo, target};
use crate::tree;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::UNIX_EPOCH;

/// Where the steps leave what the next run reads.
pub(crate) fn folder(root: &Path) -> PathBuf {
    target(root).join("check")
}

/// What has passed.
fn file(root: &Path) -> PathBuf {
    folder(root).join("passed")
}

/// Forgets what has passed.
pub(crate) fn forget(root: &Path) -> Result<(), String> {
    let file = file(root);
    if !file.exists() {
        return Ok(());
    }
    std::fs::remove_file(&file).map_err(|e| format!("{}: {e}", file.display()))
}

/// Whether cargo builds a file anew where it changes, so that it needs no other watch.
fn is_source(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "rs")
}

/// Beginnings of the variables of the environment that tests read, and of those by which cargo compiles.
const VARIABLES: [&str; 6] =
    ["SINEW_", "PROPTEST_", "RUSTFLAGS", "RUSTDOCFLAGS", "CARGO_ENCODED_", "CARGO_PROFILE_"];

/// What tests may read beside their own program: the state of all files of the project but those whose change makes cargo build
/// something anew, and variables of the environment.
pub(crate) fn state_of_data(root: &Path) -> Result<String, String> {
    let files = tree::files(root)?.into_iter().filter(|file| !is_source(file));
    let chosen = |name: &str| VARIABLES.iter().any(|beginning| name.starts_with(beginning));
    let variables = std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(chosen));
    let mut hasher = DefaultHasher::new();
    variables.collect::<BTreeMap<_, _>>().hash(&mut hasher);
    Ok(format!("{:x} {:x}", state(root, &files.collect::<Vec<_>>()), hasher.finish()))
}

/// A program, and the data that it may read.
pub(crate) fn state_of_program(root: &Path, program: &Path, data: &str) -> Result<String, String> {
    if !root.join(program).is_file() {
        return Err(format!("{}: the build has not made it", program.display()));
    }
    Ok(format!("{:x} {data}", state(root, &[program.to_path_buf()])))
}

/// What the examples in the documentation depend on: the compiler, the sources of all packages with a library, and data.
pub(crate) fn state_of_libraries(root: &Path) -> Result<String, String> {
    let of_library = |file: &PathBuf| {
        let package = file.ancestors().find(|folder| root.join(folder).join("Cargo.toml").is_file());
        is_source(file) && package.is_some_and(|package| root.join(package).join("src/lib.rs").is_file())
    };
    let sources: Vec<_> = tree::files(root)?.into_iter().filter(of_library).collect();
    let version = cargo(root, &["--version"]).output().map_err(|e| format!("cargo --version: {e}"))?.stdout;
    let version = String::from_utf8_lossy(&version).trim().to_owned();
    Ok(format!("{version} {:x} {}", state(root, &sources), state_of_data(root)?))
}

/// Runs what has not passed in the state of `now`, and remembers that it has.
pub(crate) fn unless(
    root: &Path,
    id: &str,
    now: String,
    run: impl FnOnce() -> Result<(), String>,
) -> Result<(), String> {
    let mut passed = Passed::of(root);
    if passed.holds(id, &now) {
        println!("{id} has passed as it is (`--again` runs it)");
        return Ok(());
    }
    run()?;
    passed.remember([(id.to_owned(), now)].into())
}

/// One number for the sizes and times of files.
pub(crate) fn state(root: &Path, files: &[PathBuf]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for file in files {
        let metadata = std::fs::metadata(root.join(file)).ok();
        let modified =
            metadata.as_ref().and_then(|metadata| metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok());
        (file, metadata.map(|metadata| metadata.len()), modified).hash(&mut hasher);
    }
    hasher.finish()
}

/// Names and the states in which they passed, kept in a file.
pub(crate) struct Passed {
    file: PathBuf,
    states: BTreeMap<String, String>,
}

impl Passed {
    /// What an earlier run has left, nothing where there is none.
    pub(crate) fn of(root: &Path) -> Self {
        Self::read(file(root))
    }

    fn read(file: PathBuf) -> Self {
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let line = |line: &str| line.split_once('\t').map(|(id, state)| (id.to_owned(), state.to_owned()));
        Self { file, states: text.lines().filter_map(line).collect() }
    }

    /// Whether it has passed in this state.
    pub(crate) fn holds(&self, id: &str, state: &str) -> bool {
        self.states.get(id).is_some_and(|passed| passed == state)
    }

    /// Keeps states that have passed, beside those that other steps have kept since.
    pub(crate) fn remember(&mut self, states: BTreeMap<String, String>) -> Result<(), String> {
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let _writes = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        *self = Self::read(std::mem::take(&mut self.file));
        self.states.extend(states);
        if let Some(folder) = self.file.parent() {
            std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        let text: String = self.states.iter().map(|(id, state)| format!("{id}\t{state}\n")).collect();
        std::fs::write(&self.file, text).map_err(|e| format!("{}: {e}", self.file.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_passed_is_kept_by_name_and_state() {
        let folder = std::env::temp_dir().join(format!("sinew-xtask-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("passed");
        let mut passed = Passed::read(file.clone());
        assert!(!passed.holds("sinew::lib", "1 2"));
        passed.remember(BTreeMap::from([("sinew::lib".to_owned(), "1 2".to_owned())])).unwrap();
        let passed = Passed::read(file);
        assert!(passed.holds("sinew::lib", "1 2") && !passed.holds("sinew::lib", "1 3"));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_file_that_grows_has_another_state() {
        let file = std::env::temp_dir().join(format!("sinew-xtask-state-{}", std::process::id()));
        let of = |text: &str| {
            std::fs::write(&file, text).unwrap();
            state(Path::new("/"), std::slice::from_ref(&file))
        };
        assert_ne!(of("1"), of("12"));
        std::fs::remove_file(&file).unwrap();
        assert_ne!(state(Path::new("/"), &[file]), 0);
    }
}
