//! Files of triangles that a robot names.

use super::root::{found, resolved};
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Largest file that is read, bytes.
const LARGEST: u64 = 128 << 20;
/// Folders in which packages of ROS are looked for: that of the robot and seven above it.
const FOLDERS_ABOVE: usize = 8;
/// Folders of a root in which they are looked for.
const MOST_FOLDERS: usize = 100_000;

/// Bytes of a mesh file as the robot at `path` names it: relative to its folder, absolute, or a
/// URI that begins with `file://`, `package://` or `model://`. It lies in the [root](found).
///
/// # Errors
/// The reason why it cannot be read.
pub fn mesh_bytes(path: &Path, file: &str, root: Option<&Path>) -> Result<Vec<u8>, String> {
    bytes_in(path.parent().unwrap_or(Path::new("")), file, root)
}

/// Whether a file is one of triangles by its name.
pub(super) fn is_mesh(file: &str) -> bool {
    let extension = Path::new(file).extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| {
        ["stl", "obj", "msh"].iter().any(|kind| extension.eq_ignore_ascii_case(kind))
    })
}

/// Triangles of a file that a robot in a folder names, as lines `v x y z` and `f i j k`.
pub(super) fn mesh_text(folder: &Path, file: &str, root: Option<&Path>) -> Result<String, String> {
    let surface = sinew_view::surface_of(file, &mut |file| bytes_in(folder, file, root))?;
    let mut text = String::new();
    for [x, y, z] in &surface.vertices {
        // Writing to a text never fails.
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in surface.triangles.iter().map(|corners| corners.map(|k| k + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    Ok(text)
}

fn bytes_in(folder: &Path, file: &str, root: Option<&Path>) -> Result<Vec<u8>, String> {
    let unread = |error: std::io::Error| format!("cannot be read: {error}");
    let path = match file.strip_prefix("package://").or_else(|| file.strip_prefix("model://")) {
        Some(inner) => in_package(folder, inner, root)?,
        None => {
            let path = file.strip_prefix("file://").unwrap_or(file);
            if path.contains("://") {
                return Err(
                    "expected a path, or a URI that begins with file://, package:// or model://".into()
                );
            }
            found(folder, Path::new(path), root)?
        }
    };
    let about = std::fs::metadata(&path).map_err(unread)?;
    if !about.is_file() || about.len() > LARGEST {
        return Err(format!("expected a file of at most {} MiB", LARGEST >> 20));
    }
    std::fs::read(&path).map_err(unread)
}

/// A file of a package of ROS: in the robot's folder, beside it, in those above it; then, of all folders
/// of the root, in the one with the name of the package that is nearest to the root.
fn in_package(folder: &Path, inner: &str, root: Option<&Path>) -> Result<PathBuf, String> {
    let package = inner.split('/').next().unwrap_or_default();
    let (above, root) = (resolved(folder)?, root.map(resolved).transpose()?);
    let mut places = Vec::new();
    for folder in above.ancestors().take(FOLDERS_ABOVE) {
        let own = folder.file_name().is_some_and(|name| name == package).then(|| folder.parent()).flatten();
        places.extend(own.into_iter().chain([folder]).map(Path::to_owned));
    }
    places.extend(root.iter().flat_map(|root| with_folder(root, package)));
    let mut candidates = places.iter().filter(|place| place.join(inner).exists());
    match (candidates.next(), root) {
        (Some(place), root) => found(place, Path::new(inner), root.as_deref()),
        (None, Some(root)) => Err(format!("no folder {package} in the root {} contains it", root.display())),
        (None, None) => Err(format!("no folder {package} beside or above the robot's contains it")),
    }
}

/// Folders of a root that hold one of this name, the nearest to the root first; links are not followed.
fn with_folder(root: &Path, name: &str) -> Vec<PathBuf> {
    let (mut places, mut open, mut seen) = (Vec::new(), VecDeque::from([root.to_owned()]), 0);
    while let Some(folder) = open.pop_front().filter(|_| seen < MOST_FOLDERS) {
        seen += 1;
        let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        let mut inside: Vec<PathBuf> = folders.map(|entry| entry.path()).collect();
        inside.sort();
        if inside.iter().any(|inside| inside.file_name().is_some_and(|own| own == name)) {
            places.push(folder);
        }
        open.extend(inside);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::mesh_bytes;

    #[test]
    fn meshes_are_found_beside_the_robot_and_in_packages_above_it() {
        let folder = tempfile::tempdir().unwrap();
        let package = folder.path().join("arm_description");
        std::fs::create_dir_all(package.join("meshes")).unwrap();
        std::fs::create_dir_all(package.join("urdf")).unwrap();
        std::fs::write(package.join("meshes/a.stl"), b"a").unwrap();
        let robot = package.join("urdf/arm.urdf");
        let absolute = format!("file://{}", package.join("meshes/a.stl").display());
        for file in ["package://arm_description/meshes/a.stl", "../meshes/a.stl", &absolute] {
            assert_eq!(mesh_bytes(&robot, file, None).unwrap(), b"a", "{file}");
        }
        for (file, words) in [
            ("package://legs/a.stl", "no folder legs beside or above the robot's contains it"),
            ("http://host/a.stl", "expected a path, or a URI"),
            ("../meshes", "expected a file"),
            ("none.stl", "cannot be read"),
        ] {
            let problem = mesh_bytes(&robot, file, None).unwrap_err();
            assert!(problem.contains(words), "{file}: {problem}");
        }
    }
}
