//! The core on processors that this machine is not: what it depends on there.

use crate::commands::{cargo, succeed};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// A Cortex-M4F or M7.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Crates that are known to build without an operating system.
const PORTABLE: [&str; 6] = ["libm", "ruint", "serde", "serde_core", "sinew", "thiserror"];

/// Holds the dependencies of `sinew` without its default features against the portable ones; compiles it
/// where the target is installed.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let mut tree = cargo(root, &["tree", "--package", "sinew", "--no-default-features", "--target", TARGET]);
    // Macros run on the host.
    let output =
        tree.args(["--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{lib}"]).output();
    let output = output.map_err(|e| format!("cargo tree: {e}"))?;
    if !output.status.success() {
        return Err(format!("cargo tree: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let found = crates(&String::from_utf8_lossy(&output.stdout));
    let strange: Vec<&String> = found.iter().filter(|name| !PORTABLE.contains(&name.as_str())).collect();
    if !strange.is_empty() {
        return Err(format!(
            "crates/sinew/Cargo.toml: for {TARGET} `sinew` depends on {strange:?}: expected dependencies of \
                processors in a [target.'cfg(..)'.dependencies], or a crate of {PORTABLE:?}"
        ));
    }
    if !installed() {
        println!("{} crates for {TARGET}; not compiled: rustup target add {TARGET}", found.len());
        return Ok(());
    }
    succeed(&mut cargo(root, &["check", "--package", "sinew", "--no-default-features", "--target", TARGET]))
}

/// Names of crates, one a line; lines that mark a repetition have more behind the name.
fn crates(tree: &str) -> BTreeSet<String> {
    let names = tree.lines().filter_map(|line| line.split_whitespace().next());
    names.map(str::to_owned).collect()
}

fn installed() -> bool {
    let libraries = Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]).output();
    let Ok(libraries) = libraries else { return false };
    Path::new(String::from_utf8_lossy(&libraries.stdout).trim()).is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_crates_are_read_once_each() {
        assert_eq!(crates("sinew\nlibm\nserde (*)\nlibm (*)\n\n").len(), 3);
    }
}
