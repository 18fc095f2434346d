//! The Python package, checked in an environment of its own below `target`.

use crate::commands::{cargo, succeed};
use std::path::Path;
use std::process::{Command, Stdio};

/// What builds the package, and what its tests cannot do without.
const PACKAGES: [&str; 6] = ["hypothesis", "jsonschema", "maturin>=1.9,<2", "mypy", "numpy>=1.26", "pytest"];

/// What parts of the package work with; tests of those that cannot be installed are skipped with a message.
/// Not among them: stable-baselines3, which brings gigabytes of PyTorch; where it is installed, it is tested.
const OPTIONAL: [&str; 10] = [
    "gymnasium>=1.1",
    "cmaes",
    "ipykernel",
    "matplotlib",
    "mujoco",
    "nbclient",
    "optuna>=4",
    "pandas",
    "polars",
    "ray>=2.40",
];

/// Older versions of MuJoCo with which `sinew.mujoco` is tested: the oldest whose `MjSpec` configures
/// plugins, one in the middle.
const OLDER_MUJOCO: [&str; 2] = ["3.3.3", "3.17.0"];

/// Builds the native part, then runs the tests; skipped with a message where there is no Python.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let environment = root.join("target/python");
    let interpreter = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if let Err(missing) = prepare(root, &environment, &interpreter) {
        println!("skipped: {missing}");
        return Ok(());
    }
    // Both packages at once: the features of the dependencies are then those of the build for Python.
    succeed(&mut cargo(
        root,
        &["build", "--package", "sinew-py", "--package", "sinew-py-golden", "--all-features"],
    ))?;
    let mut maturin = python(root, &interpreter, &["-m", "maturin", "develop", "--quiet"]);
    let target = root.join("target");
    succeed(maturin.env("CARGO_TARGET_DIR", &target).env("VIRTUAL_ENV", &environment))?;
    let golden = target.join("debug").join(format!("sinew-py-golden{}", std::env::consts::EXE_SUFFIX));
    succeed(python(root, &interpreter, &["-m", "pytest", "--quiet"]).env("SINEW_GOLDEN", golden))?;
    OLDER_MUJOCO.iter().try_for_each(|version| with_mujoco(root, &interpreter, version))
}

/// The tests with MuJoCo once more, with another version of it from a folder of its own.
fn with_mujoco(root: &Path, interpreter: &Path, version: &str) -> Result<(), String> {
    let folder = root.join("target").join(format!("mujoco-{version}"));
    let (package, place) = (format!("mujoco=={version}"), folder.display().to_string());
    if !folder.join("mujoco").is_dir() {
        let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"];
        let mut pip = python(root, interpreter, &install);
        if let Err(error) = succeed(pip.args(["--target", &place, &package])) {
            println!("skipped: {package} could not be installed: {error}");
            return Ok(());
        }
    }
    println!("with {package}");
    let tests = ["-m", "pytest", "--quiet", "-k", "mujoco", "python/tests"];
    succeed(python(root, interpreter, &tests).env("PYTHONPATH", &folder))
}

/// An environment with all packages, or what is missing for one.
fn prepare(root: &Path, environment: &Path, interpreter: &Path) -> Result<(), String> {
    // One that was left half made has an interpreter, but no pip.
    let mut pip = python(root, interpreter, &["-m", "pip", "--version"]);
    if !pip.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success()) {
        let version = "import sys; sys.exit(sys.version_info < (3, 11))";
        let new_enough = |name: &str| {
            let mut command = Command::new(name);
            let status = command.args(["-c", version]).stdout(Stdio::null()).stderr(Stdio::null()).status();
            status.is_ok_and(|status| status.success())
        };
        let found = ["python3", "python"].into_iter().find(|name| new_enough(name));
        let name = found.ok_or("there is no Python 3.11 or newer")?;
        let place = environment.display().to_string();
        succeed(&mut python(root, Path::new(name), &["-m", "venv", "--clear", &place]))
            .map_err(|error| format!("no environment could be made: {error}"))?;
    }
    install(root, interpreter, &PACKAGES)
        .map_err(|error| format!("the packages of its tests could not be installed: {error}"))?;
    if install(root, interpreter, &OPTIONAL).is_err() {
        // One that is not there, for this interpreter for example, keeps out no other.
        for package in OPTIONAL {
            if let Err(error) = install(root, interpreter, &[package]) {
                println!("without {package}: {error}");
            }
        }
    }
    Ok(())
}

fn install(root: &Path, interpreter: &Path, packages: &[&str]) -> Result<(), String> {
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    succeed(python(root, interpreter, &pip).args(packages))
}

fn python(root: &Path, interpreter: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(interpreter);
    command.current_dir(root).args(arguments);
    command
}
