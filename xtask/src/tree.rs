//! The files of the project.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the workspace: what cargo says that runs this program, for a copied folder of builds holds
/// programs of another checkout.
pub(crate) fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
    here.parent().map_or_else(|| here.clone(), Path::to_path_buf)
}

/// Every file of the project, relative to the root, sorted: what git tracks or would track, or all that is
/// there where the tree is no repository.
pub(crate) fn files(root: &Path) -> Result<Vec<PathBuf>, String> {
    let listed = Command::new("git")
        .current_dir(root)
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .output();
    let mut files = match listed {
        Ok(output) if output.status.success() => {
            let names = String::from_utf8_lossy(&output.stdout).into_owned();
            names.split('\0').filter(|name| !name.is_empty()).map(PathBuf::from).collect()
        }
        _ => {
            let mut files = Vec::new();
            walk(root, Path::new(""), &mut files)?;
            files
        }
    };
    // A file deleted but not yet staged is still listed.
    files.retain(|file| root.join(file).is_file());
    files.sort();
    files.dedup();
    if files.is_empty() { Err(format!("no files under {}", root.display())) } else { Ok(files) }
}

/// The Rust sources under a folder of the project, with their text.
pub(crate) fn sources(root: &Path, under: &str) -> Result<Vec<(PathBuf, String)>, String> {
    let mut found = Vec::new();
    walk(root, Path::new(under), &mut found)?;
    found.retain(|file| file.extension().is_some_and(|e| e == "rs"));
    found.sort();
    let read = |file: PathBuf| {
        let text =
            std::fs::read_to_string(root.join(&file)).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok((file, text))
    };
    found.into_iter().map(read).collect()
}

fn walk(root: &Path, folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let place = root.join(folder);
    let entries = std::fs::read_dir(&place).map_err(|e| format!("{}: {e}", place.display()))?;
    for entry in entries {
        let entry = entry.map_err(|e| format!("{}: {e}", place.display()))?;
        let name = entry.file_name();
        let built = name == "target" || name == ".git" || name == "out";
        let path = folder.join(&name);
        if entry.path().is_dir() && !built {
            walk(root, &path, files)?;
        } else if entry.path().is_file() {
            files.push(path);
        }
    }
    Ok(())
}
