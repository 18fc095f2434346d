//! Puts the commit into the program's version, where the sources are a checkout and git is there.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=SINEW_COMMIT");
    let given = std::env::var("SINEW_COMMIT").ok().filter(|commit| !commit.is_empty());
    let commit = given.or_else(checkout).unwrap_or_else(|| "commit unknown".to_owned());
    println!("cargo::rustc-env=SINEW_COMMIT={commit}");
}

/// The commit of this checkout; none outside of one, in a checkout of another project, or without git.
fn checkout() -> Option<String> {
    // In a checkout of another project, into which this one was copied, the manifest has another place.
    let place = git(&["ls-files", "--full-name", "Cargo.toml"])?;
    if place != "crates/sinew-cli/Cargo.toml" {
        return None;
    }
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    println!("cargo::rerun-if-changed={log}");
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.trim().to_owned())
}
