//! A machine from a file (TOML, MJCF or URDF) or by the name of a built-in one.

use crate::failure::Failure;
use sinew::description::machine::FileReference;
use sinew::description::{MachineDescription, from_mjcf, from_urdf, machine_from_toml, machine_of};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Built-in machines: name and file.
pub(crate) const BUILT_IN: [(&str, &str); 8] = [
    ("lm_arm", include_str!("../../../models/lm_arm.toml")),
    ("bench_joint", include_str!("../../../models/bench_joint.toml")),
    ("planar_leg", include_str!("../../../models/planar_leg.toml")),
    ("finger", include_str!("../../../models/finger.toml")),
    ("exosuit_elbow", include_str!("../../../models/exosuit_elbow.toml")),
    ("surgical_wrist", include_str!("../../../models/surgical_wrist.toml")),
    ("shoulder", include_str!("../../../models/shoulder.toml")),
    ("chain10", include_str!("../../../models/chain10.toml")),
];

/// Reads and validates a machine; a file takes precedence over a built-in machine of the same name.
pub(crate) fn load(source: &Path, muscles: Option<&Path>) -> Result<MachineDescription, Failure> {
    let name = source.display().to_string();
    let extension = source.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if muscles.is_some() && extension != "urdf" {
        return Err(Failure::refused(format!(
            "{name}: contains its muscles: expected `muscles` with a .urdf file only"
        )));
    }
    let built_in = BUILT_IN.iter().find(|(known, _)| name == *known && !source.exists());
    if let Some((_, text)) = built_in {
        return Ok(machine_from_toml(&name, text, &mut |file| beside(source, file))?);
    }
    match extension.as_str() {
        "toml" => Ok(machine_from_toml(&name, &read_text(source)?, &mut |file| beside(source, file))?),
        "xml" | "mjcf" => {
            let folder = folder_of(source);
            let described = from_mjcf(&name, &read_text(source)?, &mut |file| include(&folder, file))?;
            Ok(machine_of(described)?)
        }
        "urdf" => {
            let text = read_text(source)?;
            let beside = source.with_extension("muscles.toml");
            let muscles = muscles.map(Path::to_owned).or_else(|| beside.exists().then_some(beside));
            let muscles =
                muscles.map(|file| Ok::<_, Failure>((file.display().to_string(), read_text(&file)?)));
            let muscles = muscles.transpose()?;
            let muscles = muscles.as_ref().map(|(name, text)| (name.as_str(), text.as_str()));
            Ok(machine_of(from_urdf(&name, &text, muscles)?)?)
        }
        _ => Err(Failure::refused(format!(
            "{name}: expected a file ending in .toml, .xml or .urdf, or the name of a built-in machine: {}",
            BUILT_IN.map(|(known, _)| known).join(", ")
        ))),
    }
}

/// Largest file that is read, MB; real ones have some ten kilobytes.
const MAX_FILE_MB: u64 = 64;

/// Text of a file of bounded size, without a byte order mark.
fn read_text(path: &Path) -> Result<String, Failure> {
    let name = path.display();
    let unreadable =
        |e: std::io::Error| Failure::Unreadable(format!("{name}: cannot be read: {e}"), e.kind());
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take((MAX_FILE_MB << 20) + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_MB << 20 {
        return Err(Failure::refused(format!("{name}: expected at most {MAX_FILE_MB} MB, got more")));
    }
    let text = String::from_utf8(bytes)
        .map_err(|e| Failure::refused(format!("{name}: expected text (UTF-8), got {}", e.utf8_error())))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// Text of a file that a machine file names, or the reason why it cannot be read.
fn beside(machine: &Path, file: FileReference<'_>) -> Result<String, String> {
    let folder = folder_of(machine);
    match file.included_by {
        Some(body) => include(&folder_of(&folder.join(body)), file.path),
        None => read_text(&folder.join(file.path)).map_err(|failure| failure.to_string()),
    }
}

/// Text of a file that an MJCF model includes: only files within the model's folder are read, also after symbolic
/// links are resolved.
fn include(folder: &Path, file: &str) -> Result<String, String> {
    let inside = Path::new(file).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = folder.join(file);
    let real = root.canonicalize().and_then(|root| Ok((path.canonicalize()?, root)));
    match real {
        Err(e) => Err(format!("cannot be read: {e}")),
        Ok((path, root)) if inside && path.starts_with(&root) => {
            read_text(&path).map_err(|failure| failure.to_string())
        }
        Ok(_) => Err("lies outside the model's folder: expected a file within it".to_owned()),
    }
}
