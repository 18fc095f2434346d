//! The live page in a headless Chromium, and the types of its scripts where node is present.

use crate::commands::{cargo, succeed, target};
use crate::readme;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The crate that drives the browser, a workspace of its own.
pub(crate) const MANIFEST: &str = "crates/sinew-view/browser/Cargo.toml";
/// Scripts that import all others.
const ENTRIES: [&str; 2] = ["live/main.js", "view/report.js"];
/// Packages of the check alone: they never reach the program.
const PACKAGES: [&str; 3] = ["typescript@7", "@types/three@0.185", "axe-core@4"];

/// Types of the scripts, then the page in a browser.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    // All builds come first: steps beside this one keep others from building for minutes.
    let program = readme::program(root)?;
    // The folder of the other steps, whose dependencies serve here as well.
    let build = ["build", "--quiet", "--manifest-path", MANIFEST, "--target-dir"];
    succeed(cargo(root, &build).arg(target(root)))?;
    let folder = root.join("target/page");
    let packages = packages(&folder);
    match &packages {
        Some(packages) => types(root, &folder, packages)?,
        None => println!("types of the scripts and accessibility: skipped, npm or its packages are not here"),
    }
    let driver = format!("debug/sinew-view-browser{}", std::env::consts::EXE_SUFFIX);
    let mut command = Command::new(target(root).join(driver));
    command.current_dir(root).args(["--out", "out/page", "--program"]).arg(program);
    if let Some(packages) = packages {
        command.arg("--axe").arg(packages.join("axe-core/axe.min.js"));
    }
    succeed(&mut command)
}

/// The folder of the packages, installed if they are not there yet; none without npm or network.
fn packages(folder: &Path) -> Option<PathBuf> {
    let installed = folder.join("node_modules");
    if !installed.join("axe-core/axe.min.js").is_file() {
        std::fs::create_dir_all(folder).ok()?;
        let mut command = Command::new("npm");
        command.args(["install", "--no-audit", "--no-fund", "--prefix"]).arg(folder).args(PACKAGES);
        let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status().ok()?;
        if !status.success() {
            return None;
        }
    }
    Some(installed)
}

/// Holds the JSDoc types of the scripts against their code.
fn types(root: &Path, folder: &Path, packages: &Path) -> Result<(), String> {
    let assets = root.join("crates/sinew-view/assets");
    let quoted = |path: PathBuf| format!("\"{}\"", path.display());
    let files: Vec<String> = ENTRIES.iter().map(|entry| quoted(assets.join(entry))).collect();
    let settings = format!(
        r#"{{"compilerOptions": {{"allowJs": true, "checkJs": true, "noEmit": true, "strict": true, "target": "es2024",
  "module": "esnext", "moduleResolution": "bundler", "lib": ["es2024", "dom", "dom.iterable"], "skipLibCheck": true,
  "types": [], "paths": {{"three": [{}]}}}}, "files": [{}]}}"#,
        quoted(packages.join("@types/three")),
        files.join(", ")
    );
    let file = folder.join("tsconfig.json");
    std::fs::write(&file, settings).map_err(|e| format!("{}: {e}", file.display()))?;
    succeed(Command::new(packages.join(".bin/tsc")).arg("--project").arg(&file))?;
    println!("types of the scripts: no error");
    Ok(())
}
