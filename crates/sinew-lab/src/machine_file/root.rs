//! Where the files lie that a robot names.

use std::path::{Component, Path, PathBuf};

/// Path of a file that a robot in a folder names, links resolved, or the reason why it may not be read.
///
/// It has to lie below `root`, also where links lead it; without a root below the nearest folder that
/// holds the robot's folder and the file, which may not be the root of the file system.
///
/// # Errors
/// The reason, with the path that was tried and the root.
pub fn found(folder: &Path, name: &Path, root: Option<&Path>) -> Result<PathBuf, String> {
    let folder = resolved(folder)?;
    let tried = folder.join(name);
    let allowed = match root {
        Some(root) => Some(resolved(root)?),
        None => nearest(&folder, &tried),
    };
    let Some(allowed) = allowed else {
        let folder = folder.display();
        return Err(format!(
            "{} and {folder} have no folder in common but that of all files: state a root",
            plain(&tried).display()
        ));
    };
    let unread = |error| format!("{} cannot be read: {error}; root {}", tried.display(), allowed.display());
    let path = tried.canonicalize().map_err(unread)?;
    if !path.starts_with(&allowed) {
        let allowed = allowed.display();
        return Err(format!("{} lies outside the root {allowed}: expected a file in it", path.display()));
    }
    Ok(path)
}

/// The folder itself, links resolved.
pub(super) fn resolved(folder: &Path) -> Result<PathBuf, String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    folder.canonicalize().map_err(|error| format!("{} cannot be read: {error}", folder.display()))
}

/// The nearest folder that holds both, but for that of all files.
fn nearest(folder: &Path, file: &Path) -> Option<PathBuf> {
    let file = plain(file);
    let common = folder.ancestors().find(|folder| file.starts_with(folder))?;
    common.parent().map(|_| common.to_owned())
}

/// An absolute path without `.` and `..`, whatever its links are.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            other => plain.push(other),
        }
    }
    plain
}
