//! What a user installs without a compiler: the Python package and an archive of the program, for Linux on
//! x86-64 with an old glibc, each tried as a new user would.

use crate::commands::{cargo, succeed};
use crate::python::{environment, install, python};
use crate::tree;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Zig links against the old glibc; auditwheel says which one the wheel needs; wheel packs it.
const PACKAGES: [&str; 5] = ["maturin>=1.9,<2", "ziglang", "auditwheel", "cargo-zigbuild", "wheel"];
/// glibc 2.17, of 2012.
const PLATFORM: &str = "manylinux_2_17";
const TARGET: &str = "x86_64-unknown-linux-gnu";
const GLIBC: &str = "2.17";
const FOLDER: &str = "target/dist";
/// The wheel as maturin leaves it, without the program.
const BUILT: &str = "target/wheel/built";
const MANIFEST: &str = "crates/sinew-cli/Cargo.toml";
const FEATURES: &str = "parquet,mat73,ros,foxglove";
/// Of the archive, beside the program and what it writes of itself: what its README leads to.
const TEXTS: [&str; 9] = [
    "README.md",
    "FEATURES.md",
    "CHANGELOG.md",
    "ARCHITECTURE.md",
    "NOTATION.md",
    "CONTRIBUTING.md",
    "CITATION.cff",
    "LICENSE-MIT",
    "LICENSE-APACHE",
];
const FOLDERS: [&str; 2] = ["docs", "clients"];
const SHELLS: [&str; 3] = ["bash", "fish", "zsh"];
/// Scripts of others in the program's pages.
const SCRIPTS: [&str; 2] = ["three", "uplot"];

/// What a new user does first: a model from two logs, and a machine.
const FIRST: &str = "
import pathlib, sinew
logs = dict(list(sinew.demo_logs().items())[:2])
for name, text in logs.items(): pathlib.Path(name).write_text(text)
print(sinew.__version__, sinew.identify(list(logs), far='tension_out_n', models=['cell']), sinew.Machine('lm_arm'))";
/// An interpreter that ends while another thread is in a call.
const ENDING: &str = "
import threading, time, sinew
threading.Thread(target=lambda: sinew.track(sinew.Machine('lm_arm')), daemon=True).start()
time.sleep(0.3)";
const FIRST_COMMANDS: &str = "
./sinew twin bench --speeds 0.04,0.08 --duration 10 --out bench.csv
./sinew identify bench.csv --out cable --model cell
./sinew evaluate cable/model.json bench.csv";

/// Builds wheel and source distribution, has the wheel judged, and uses it in a clean environment.
pub(crate) fn wheel(root: &Path) -> Result<(), String> {
    let (tools, path) = tools(root)?;
    // Emptied, so that the only wheel is the one that is built.
    let folder = emptied(root, BUILT)?;
    let build = ["-m", "maturin", "build", "--release", "--locked", "--zig", "--compatibility", PLATFORM];
    let mut build = python(root, &tools, &build);
    build.args(["--target", TARGET, "--out", BUILT, "--"]).args(system_unwinder()?);
    succeed(build.env("PATH", &path))?;
    let wheel = add_program(root, &tools, &only_entry(&folder)?, &program(root, &tools, &path)?)?;
    succeed(&mut python(root, &tools, &["-m", "auditwheel", "show", &wheel]))?;
    succeed(&mut python(root, &tools, &["-m", "maturin", "sdist", "--out", FOLDER]))?;
    let clean = emptied(root, "target/wheel/clean")?;
    let user = environment(root, &clean)?;
    let begins = Instant::now();
    install(root, &user, &[&wheel])?;
    let installed = begins.elapsed().as_secs_f64();
    succeed(python(root, &user, &["-c", FIRST]).current_dir(&clean))?;
    succeed(Command::new(user.with_file_name("sinew")).arg("--version"))?;
    let all = begins.elapsed().as_secs_f64();
    succeed(python(root, &user, &["-c", ENDING]).current_dir(&clean))?;
    println!("{wheel}: installed in {installed:.1} s, first result after {all:.1} s");
    Ok(())
}

/// Holds the dependencies against `deny.toml`, and builds every crate from what would be uploaded.
pub(crate) fn packages(root: &Path) -> Result<(), String> {
    succeed(&mut cargo(root, &["deny", "check"]))
        .map_err(|error| format!("{error} (cargo install cargo-deny)"))?;
    succeed(&mut cargo(root, &["publish", "--dry-run", "--workspace", "--locked"]))
}

/// Builds the program and packs it with completions, manual pages, the licences of all libraries and a list
/// of them in the form of CycloneDX; unpacks it and runs it without an environment.
pub(crate) fn archive(root: &Path) -> Result<(), String> {
    let (tools, path) = tools(root)?;
    let program = program(root, &tools, &path)?;
    let name = format!("sinew-{}-{TARGET}", env!("CARGO_PKG_VERSION"));
    let folder = emptied(root, &format!("target/archive/{name}"))?;
    let copy = |from: PathBuf, to: &str| {
        std::fs::copy(&from, folder.join(to)).map(drop).map_err(|e| format!("{}: {e}", from.display()))
    };
    copy(program, "sinew")?;
    TEXTS.iter().try_for_each(|text| copy(root.join(text), text))?;
    for file in tree::files(root)?.iter().filter(|file| FOLDERS.iter().any(|at| file.starts_with(at))) {
        let to = folder.join(file);
        std::fs::create_dir_all(to.parent().unwrap_or(&folder))
            .map_err(|e| format!("{}: {e}", to.display()))?;
        copy(root.join(file), &file.display().to_string())?;
    }
    SCRIPTS.iter().try_for_each(|script| {
        let vendor = root.join("crates/sinew-view/assets/vendor").join(script);
        copy(vendor.join("LICENSE"), &format!("LICENSE-{script}"))
    })?;
    let program = folder.join("sinew");
    succeed(Command::new(&program).args(["man", "--out"]).arg(folder.join("man")).stderr(Stdio::null()))?;
    for shell in SHELLS {
        let file = folder.join(format!("sinew.{shell}"));
        let file = std::fs::File::create(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        succeed(Command::new(&program).args(["completions", shell]).stdout(file))?;
    }
    let licences = folder.join("LICENSES-OF-LIBRARIES");
    let licences = std::fs::File::create(&licences).map_err(|e| format!("{}: {e}", licences.display()))?;
    let mut list = python(root, &tools, &["xtask/licences.py", MANIFEST, FEATURES, TARGET]);
    succeed(list.stdout(licences))?;
    let mut list = cargo(root, &["cyclonedx", "--quiet", "--format", "json", "--target", TARGET]);
    list.args(["--manifest-path", MANIFEST, "--features", FEATURES, "--override-filename", "sinew.cdx"]);
    succeed(&mut list).map_err(|error| format!("{error} (cargo install cargo-cyclonedx)"))?;
    copy(root.join("crates/sinew-cli/sinew.cdx.json"), "sinew.cdx.json")?;
    // It writes one beside the manifest of every crate.
    for file in tree::files(root)?.iter().filter(|file| file.ends_with("sinew.cdx.json")) {
        std::fs::remove_file(root.join(file)).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    let dist = root.join(FOLDER);
    std::fs::create_dir_all(&dist).map_err(|e| format!("{FOLDER}: {e}"))?;
    let archive = format!("{name}.tar.gz");
    let mut tar = Command::new("tar");
    tar.args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--gzip", "--create", "--file"]);
    succeed(tar.arg(dist.join(&archive)).arg("--directory").arg(root.join("target/archive")).arg(&name))?;
    let sums = dist.join(format!("{archive}.sha256"));
    let file = std::fs::File::create(&sums).map_err(|e| format!("{}: {e}", sums.display()))?;
    succeed(Command::new("sha256sum").arg(&archive).current_dir(&dist).stdout(file))?;
    let clean = emptied(root, "target/archive/clean")?;
    let begins = Instant::now();
    succeed(Command::new("tar").arg("--extract").arg("--file").arg(dist.join(&archive)).current_dir(&clean))?;
    let mut first = Command::new("/bin/sh");
    first.args(["-ec", FIRST_COMMANDS]).env_clear().current_dir(clean.join(&name));
    succeed(&mut first)?;
    println!("{FOLDER}/{archive}: unpacked, first result after {:.1} s", begins.elapsed().as_secs_f64());
    Ok(())
}

/// Packs a wheel anew with the program, so that who has it has the commands of the book: maturin takes either
/// a package or a program.
fn add_program(root: &Path, tools: &Path, wheel: &Path, program: &Path) -> Result<String, String> {
    let unpacked = emptied(root, "target/wheel/unpacked")?;
    let run = |what: &str, of: &str, flag: &str, to: &str| {
        succeed(&mut python(root, tools, &["-m", "wheel", what, of, flag, to]))
    };
    run("unpack", &wheel.display().to_string(), "--dest", &unpacked.display().to_string())?;
    let package = only_entry(&unpacked)?;
    let name = package.file_name().unwrap_or_default().display().to_string();
    let scripts = package.join(format!("{name}.data/scripts"));
    let written =
        std::fs::create_dir_all(&scripts).and_then(|()| std::fs::copy(program, scripts.join("sinew")));
    written.map_err(|e| format!("{}: {e}", scripts.display()))?;
    let folder = root.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{FOLDER}: {e}"))?;
    run("pack", &package.display().to_string(), "--dest-dir", FOLDER)?;
    Ok(folder.join(wheel.file_name().unwrap_or_default()).display().to_string())
}

/// The one file or folder in a folder.
fn only_entry(folder: &Path) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let found = entries.filter_map(|entry| Some(entry.ok()?.path())).next();
    found.ok_or_else(|| format!("nothing in {}", folder.display()))
}

/// Builds the program against the old glibc.
fn program(root: &Path, tools: &Path, path: &OsStr) -> Result<PathBuf, String> {
    let zigbuild = tools.with_file_name("cargo-zigbuild");
    let place = format!("{TARGET}.{GLIBC}");
    let mut build = python(root, &zigbuild, &["rustc", "--release", "--locked", "--package", "sinew-cli"]);
    build.args(["--bin", "sinew", "--features", FEATURES, "--target", &place, "--", "-C", "strip=symbols"]);
    succeed(build.env("PATH", path))?;
    Ok(root.join("target").join(TARGET).join("release/sinew"))
}

/// An interpreter with the tools of this file, and the `PATH` on which they are first.
fn tools(root: &Path) -> Result<(PathBuf, std::ffi::OsString), String> {
    let tools = environment(root, &root.join("target/wheel/tools"))?;
    install(root, &tools, &PACKAGES)?;
    let mut places = vec![tools.parent().unwrap_or(root).to_path_buf()];
    places.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let path = std::env::join_paths(places).map_err(|e| format!("PATH: {e}"))?;
    Ok((tools, path))
}

/// Links the library that unwinds threads dynamically. Zig would link one of its own, and Python, which ends
/// threads by unwinding them with the system's, would crash in it.
fn system_unwinder() -> Result<[String; 4], String> {
    let name = "libgcc_s.so.1";
    let mut cc = Command::new("cc");
    let found = cc.arg(format!("-print-file-name={name}")).output().map_err(|e| format!("cc: {e}"))?;
    let found = String::from_utf8_lossy(&found.stdout).trim().to_owned();
    let folder = Path::new(&found).canonicalize().ok();
    let folder = folder.as_deref().and_then(Path::parent).ok_or_else(|| format!("cc finds no {name}"))?;
    let library = format!("dylib:+verbatim={name}");
    Ok(["-l".into(), library, "-L".into(), format!("native={}", folder.display())])
}

fn emptied(root: &Path, folder: &str) -> Result<PathBuf, String> {
    let place = root.join(folder);
    if place.exists() {
        std::fs::remove_dir_all(&place).map_err(|e| format!("{folder}: {e}"))?;
    }
    std::fs::create_dir_all(&place).map_err(|e| format!("{folder}: {e}"))?;
    Ok(place)
}
