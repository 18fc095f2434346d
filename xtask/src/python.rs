//! The Python package, checked in an environment of its own below `target`.

use crate::commands::{cargo, succeed};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What builds the package, and what its tests cannot do without.
const PACKAGES: [&str; 6] = ["hypothesis", "jsonschema", "maturin>=1.9,<2", "mypy", "numpy>=1.26", "pytest"];

/// What parts of the package work with; tests of those that cannot be installed are skipped with a message.
/// Not among them: stable-baselines3, which brings gigabytes of PyTorch; where it is installed, it is tested.
const OPTIONAL: [&str; 30] = [
    "gymnasium>=1.1",
    "canopen",
    "cantools",
    "cmaes",
    "cyclonedds",
    "damiao-motor",
    "dynamixel-sdk",
    "feetech-servo-sdk",
    "ipykernel",
    "jax",
    "matplotlib",
    "mcap-ros2-support",
    "mini-cheetah-motor-driver-socketcan",
    "mujoco",
    "mujoco-mjx",
    "mujoco-warp>=3.6",
    "nbclient",
    "odrive-can",
    "onnx",
    "onnxruntime",
    "optuna>=4",
    "pandas",
    "playground",
    "polars",
    "pygame",
    "pyserial",
    "python-can",
    "ray>=2.40",
    "rosbags",
    "rustypot",
];

/// Older versions of MuJoCo with which `sinew.mujoco` is tested: the oldest whose `MjSpec` configures
/// plugins, one in the middle.
const OLDER_MUJOCO: [&[&str]; 2] = [&["mujoco==3.3.3"], &["mujoco==3.17.0"]];

/// With which the simulators of many worlds are tested by the step `batch`: the oldest of each, and the
/// MuJoCo that belongs to the newest MJX and the newest Newton.
const OLDER_BATCH: [&[&str]; 2] = [
    &["mujoco==3.6.0", "mujoco-mjx==3.6.0", "mujoco-warp==3.6.0"],
    &["mujoco==3.17.0", "mujoco-mjx==3.17.0", "mujoco-warp==3.17.0", "newton==1.8.0"],
];

/// Tests with MuJoCo, and those of many worlds, for pytest.
const MUJOCO_TESTS: &str = "mujoco";
const BATCH_TESTS: &str = "batch or jax or mjx or newton or warp";

/// Builds the native part, then runs the tests; skipped with a message where there is no Python.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let Some(interpreter) = build(root)? else { return Ok(()) };
    let golden = root.join("target/debug").join(format!("sinew-py-golden{}", std::env::consts::EXE_SUFFIX));
    succeed(pytest(root, &interpreter, &[]).env("SINEW_GOLDEN", golden))?;
    // Exports against other people's programs in that environment.
    let mut exports = cargo(root, &["test", "--package", "sinew-export", "--test", "export", "onnx"]);
    succeed(exports.env("SINEW_PYTHON", &interpreter))?;
    OLDER_MUJOCO.iter().try_for_each(|packages| with(root, &interpreter, packages, MUJOCO_TESTS))
}

/// All tests of simulators of many worlds, the long ones too, with the newest and with older versions.
pub(crate) fn batch(root: &Path) -> Result<(), String> {
    let Some(interpreter) = build(root)? else { return Ok(()) };
    succeed(pytest(root, &interpreter, &["-k", BATCH_TESTS]).env("SINEW_LONG", "1"))?;
    OLDER_BATCH.iter().try_for_each(|packages| with(root, &interpreter, packages, BATCH_TESTS))
}

/// The interpreter of an environment with the package, or nothing and a message.
fn build(root: &Path) -> Result<Option<PathBuf>, String> {
    let environment = root.join("target/python");
    let interpreter = match prepare(root, &environment) {
        Ok(interpreter) => interpreter,
        Err(missing) => {
            println!("skipped: {missing}");
            return Ok(None);
        }
    };
    // At once: the features of the dependencies are then those of the build for Python. The program is run by
    // tests beside other people's.
    let packages = ["sinew-py", "sinew-py-golden", "sinew-cli"].map(|name| ["--package", name]);
    succeed(cargo(root, &["build", "--all-features"]).args(packages.as_flattened()))?;
    let mut maturin = python(root, &interpreter, &["-m", "maturin", "develop", "--quiet"]);
    let target = root.join("target");
    succeed(maturin.env("CARGO_TARGET_DIR", &target).env("VIRTUAL_ENV", &environment))?;
    Ok(Some(interpreter))
}

/// Tests with other versions of packages, the first of them MuJoCo, from a folder of their own.
fn with(root: &Path, interpreter: &Path, packages: &[&str], tests: &str) -> Result<(), String> {
    let name = packages.join(" ").replace("==", "-");
    let folder = root.join("target").join(name.replace(' ', "+"));
    if !folder.join("mujoco").is_dir() {
        let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"];
        let mut pip = python(root, interpreter, &install);
        if let Err(error) = succeed(pip.arg("--target").arg(&folder).args(packages)) {
            println!("skipped: {name} could not be installed: {error}");
            return Ok(());
        }
    }
    println!("with {name}");
    let mut run = pytest(root, interpreter, &["-k", tests, "python/tests"]);
    if tests == BATCH_TESTS {
        run.env("SINEW_LONG", "1");
    } else {
        // Their packages do not even load beside an older MuJoCo.
        run.args(["--ignore-glob", "*/test_mjx*", "--ignore-glob", "*/test_warp*"]);
    }
    succeed(run.env("PYTHONPATH", &folder))
}

/// The tests, with what JAX and Warp compile kept from run to run.
fn pytest(root: &Path, interpreter: &Path, arguments: &[&str]) -> Command {
    let mut command = python(root, interpreter, &["-m", "pytest", "--quiet"]);
    let target = root.join("target");
    command.args(arguments).env("WARP_CACHE_PATH", target.join("warp"));
    command.env("JAX_COMPILATION_CACHE_DIR", target.join("jax"));
    command
}

/// The interpreter of an environment, which is made where it is not there.
pub(crate) fn environment(root: &Path, environment: &Path) -> Result<PathBuf, String> {
    let interpreter = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    // One that was left half made has an interpreter, but no pip.
    let mut pip = python(root, &interpreter, &["-m", "pip", "--version"]);
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
    Ok(interpreter)
}

/// The interpreter of an environment with all packages, or what is missing for one.
fn prepare(root: &Path, place: &Path) -> Result<PathBuf, String> {
    let interpreter = environment(root, place)?;
    install(root, &interpreter, &PACKAGES)
        .map_err(|error| format!("the packages of its tests could not be installed: {error}"))?;
    if install(root, &interpreter, &OPTIONAL).is_err() {
        // One that is not there, for this interpreter for example, keeps out no other.
        for package in OPTIONAL {
            if let Err(error) = install(root, &interpreter, &[package]) {
                println!("without {package}: {error}");
            }
        }
    }
    Ok(interpreter)
}

pub(crate) fn install(root: &Path, interpreter: &Path, packages: &[&str]) -> Result<(), String> {
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    succeed(python(root, interpreter, &pip).args(packages))
}

pub(crate) fn python(root: &Path, interpreter: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(interpreter);
    command.current_dir(root).args(arguments);
    command
}
