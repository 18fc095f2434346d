//! Pictures of the machines that come with the program, drawn by the program itself.

use crate::commands::succeed;
use crate::readme;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the pictures are.
const FOLDER: &str = "docs/machines";

/// Draws every machine of `models/` anew.
pub(crate) fn make(root: &Path) -> Result<(), String> {
    let drawn = draw(root, &readme::program(root)?, &root.join(FOLDER))?;
    println!("{} pictures in {FOLDER}", drawn.len());
    Ok(())
}

/// Fails where a picture is not the one that the program draws.
pub(crate) fn check(root: &Path, program: &Path) -> Result<(), String> {
    for path in draw(root, program, &root.join("target/pictures"))? {
        let name = path.file_name().unwrap_or_default();
        let kept = root.join(FOLDER).join(name);
        if std::fs::read(&kept).ok() != std::fs::read(&path).ok() {
            return Err(format!("{} is not what the program draws: cargo xtask pictures", kept.display()));
        }
    }
    Ok(())
}

/// Draws all machines into a folder and says which files that made.
fn draw(root: &Path, program: &Path, folder: &Path) -> Result<Vec<PathBuf>, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut made = Vec::new();
    for (name, _) in sinew_models::MACHINES {
        let picture = folder.join(name).with_extension("svg");
        let mut command = Command::new(program);
        command.args(["machine", "show", name, "--picture"]).arg(&picture).stdout(Stdio::null());
        succeed(command.current_dir(root))?;
        made.push(picture);
    }
    Ok(made)
}
