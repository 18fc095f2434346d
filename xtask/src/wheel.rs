//! A wheel of the Python package for Linux on x86-64 with an old glibc, tried in an environment of its own.

use crate::commands::succeed;
use crate::python::{environment, install, python};
use std::path::Path;
use std::time::Instant;

/// Zig links against the old glibc; auditwheel says which one the wheel needs.
const PACKAGES: [&str; 3] = ["maturin>=1.9,<2", "ziglang", "auditwheel"];
/// glibc 2.17, of 2012.
const PLATFORM: &str = "manylinux_2_17";
const TARGET: &str = "x86_64-unknown-linux-gnu";
const FOLDER: &str = "target/dist";

/// What a new user does first: a model from two logs, and a machine.
const FIRST: &str = "
import pathlib, sinew
logs = dict(list(sinew.demo_logs().items())[:2])
for name, text in logs.items(): pathlib.Path(name).write_text(text)
print(sinew.__version__, sinew.identify(list(logs), far='tension_out_n', models=['cell']), sinew.Machine('lm_arm'))";

/// Builds it, has it judged, and uses it in a clean environment.
pub(crate) fn make(root: &Path) -> Result<(), String> {
    let tools = environment(root, &root.join("target/wheel/tools"))?;
    install(root, &tools, &PACKAGES)?;
    let mut places = vec![tools.parent().unwrap_or(root).to_path_buf()];
    places.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let path = std::env::join_paths(places).map_err(|e| format!("PATH: {e}"))?;
    let folder = root.join(FOLDER);
    // So that the only wheel is the one that is built.
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{FOLDER}: {e}"))?;
    }
    let build = ["-m", "maturin", "build", "--release", "--locked", "--zig", "--compatibility", PLATFORM];
    let mut build = python(root, &tools, &build);
    succeed(build.args(["--target", TARGET, "--out", FOLDER]).env("PATH", &path))?;
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{FOLDER}: {e}"))?;
    let wheel = entries.filter_map(|entry| Some(entry.ok()?.path())).next();
    let wheel = wheel.ok_or_else(|| format!("no wheel in {FOLDER}"))?.display().to_string();
    succeed(&mut python(root, &tools, &["-m", "auditwheel", "show", &wheel]))?;
    let clean = root.join("target/wheel/clean");
    if clean.exists() {
        std::fs::remove_dir_all(&clean).map_err(|e| format!("{}: {e}", clean.display()))?;
    }
    let user = environment(root, &clean)?;
    let begins = Instant::now();
    install(root, &user, &[&wheel])?;
    let installed = begins.elapsed().as_secs_f64();
    succeed(python(root, &user, &["-c", FIRST]).current_dir(&clean))?;
    let all = begins.elapsed().as_secs_f64();
    println!("{wheel}: installed in {installed:.1} s, first result after {all:.1} s");
    Ok(())
}
