//! Files of triangles that a robot names.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Largest file that is read, bytes.
const LARGEST: u64 = 128 << 20;
/// Folders in which packages of ROS are looked for: that of the robot and seven above it.
const FOLDERS_ABOVE: usize = 8;

/// Bytes of a mesh file as the robot at `path` names it: relative to its folder, absolute, or a
/// URI that begins with `file://`, `package://` or `model://`.
///
/// # Errors
/// The reason why it cannot be read.
pub fn mesh_bytes(path: &Path, file: &str) -> Result<Vec<u8>, String> {
    bytes_in(path.parent().unwrap_or(Path::new("")), file)
}

/// Whether a file is one of triangles by its name.
pub(super) fn is_mesh(file: &str) -> bool {
    let extension = Path::new(file).extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| {
        ["stl", "obj", "msh"].iter().any(|kind| extension.eq_ignore_ascii_case(kind))
    })
}

/// Triangles of a file that a robot in a folder names, as lines `v x y z` and `f i j k`.
pub(super) fn mesh_text(folder: &Path, file: &str) -> Result<String, String> {
    let surface = sinew_view::surface_of(file, &mut |file| bytes_in(folder, file))?;
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

fn bytes_in(folder: &Path, file: &str) -> Result<Vec<u8>, String> {
    let unread = |error: std::io::Error| format!("cannot be read: {error}");
    let found = find(folder, file)?;
    let about = std::fs::metadata(&found).map_err(unread)?;
    if !about.is_file() || about.len() > LARGEST {
        return Err(format!("expected a file of at most {} MiB", LARGEST >> 20));
    }
    std::fs::read(&found).map_err(unread)
}

/// The path of a mesh file; a package of ROS is looked for beside the robot's folder, in it and in those
/// above it.
fn find(folder: &Path, file: &str) -> Result<PathBuf, String> {
    if let Some(path) = file.strip_prefix("file://") {
        return Ok(PathBuf::from(path));
    }
    let Some(inner) = file.strip_prefix("package://").or_else(|| file.strip_prefix("model://")) else {
        if file.contains("://") {
            return Err(
                "expected a path, or a URI that begins with file://, package:// or model://".to_owned()
            );
        }
        return Ok(folder.join(file));
    };
    let package = inner.split('/').next().unwrap_or_default();
    let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let above = root.canonicalize().map_err(|error| format!("cannot be read: {error}"))?;
    let candidates = above.ancestors().take(FOLDERS_ABOVE).flat_map(|folder| {
        let own = folder.file_name().is_some_and(|name| name == package).then(|| folder.parent()).flatten();
        own.into_iter().chain([folder]).map(|folder| folder.join(inner)).collect::<Vec<_>>()
    });
    let mut existing = candidates.filter(|path| path.exists());
    existing.next().ok_or_else(|| format!("no folder {package} beside or above the robot's contains it"))
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
            assert_eq!(mesh_bytes(&robot, file).unwrap(), b"a", "{file}");
        }
        for (file, words) in [
            ("package://legs/a.stl", "no folder legs beside or above the robot's contains it"),
            ("http://host/a.stl", "expected a path, or a URI"),
            ("../meshes", "expected a file"),
            ("none.stl", "cannot be read"),
        ] {
            let problem = mesh_bytes(&robot, file).unwrap_err();
            assert!(problem.contains(words), "{file}: {problem}");
        }
    }
}
