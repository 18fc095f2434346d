//! A robot from a file or by its name.

use crate::error::Error;
use crate::output::one_line;
use crate::verbs::read_text;
use sinew::body::Robot;
use sinew::description::{Description, Warning, from_mjcf, from_toml, from_urdf};
use std::path::{Component, Path, PathBuf};

/// Robots that the program carries.
const EMBEDDED: [(&str, &str); 1] = [("lm_arm", include_str!("../../../../../models/lm_arm.toml"))];

/// A valid robot and what of its file was passed over.
pub(in crate::verbs) struct Loaded {
    pub(in crate::verbs) robot: Robot,
    pub(in crate::verbs) warnings: Vec<Warning>,
}

/// Reads a robot; files win over embedded names.
pub(in crate::verbs) fn load_robot(path: &Path, muscles: Option<&Path>) -> Result<Loaded, Error> {
    let (robot, warnings) = description(path, muscles)?.robot()?;
    Ok(Loaded { robot, warnings })
}

fn description(path: &Path, muscles: Option<&Path>) -> Result<Description, Error> {
    let embedded = EMBEDDED.iter().find(|(name, _)| path.as_os_str() == *name && !path.exists());
    if let Some((name, text)) = embedded {
        return Ok(from_toml(name, text)?);
    }
    let kind = extension(path)?;
    let text = read_text(path)?;
    let name = path.display().to_string();
    if muscles.is_some() && kind != "urdf" {
        let problem = "has its own muscles: --muscles goes with a URDF".to_owned();
        return Err(Error::File { file: path.to_owned(), problem });
    }
    match kind {
        "toml" => Ok(from_toml(&name, &text)?),
        "urdf" => {
            let beside = path.with_extension("muscles.toml");
            let file = muscles.map(Path::to_owned).or_else(|| beside.exists().then_some(beside));
            let text_of = file
                .map(|file| Ok::<_, Error>((file.display().to_string(), read_text(&file)?)))
                .transpose()?;
            Ok(from_urdf(&name, &text, text_of.as_ref().map(|(name, text)| (name.as_str(), text.as_str())))?)
        }
        _ => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            Ok(from_mjcf(&name, &text, &mut |file| include(&folder, file))?)
        }
    }
}

/// The format by the extension.
pub(super) fn extension(path: &Path) -> Result<&'static str, Error> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("toml") => Ok("toml"),
        Some("xml" | "mjcf") => Ok("xml"),
        Some("urdf") => Ok("urdf"),
        _ => Err(Error::File {
            file: path.to_owned(),
            problem: "expected a robot's file ending in .toml, .xml or .urdf, or the name of an embedded robot (lm_arm)"
                .to_owned(),
        }),
    }
}

/// An included file: within the folder of the model, links followed.
fn include(folder: &Path, file: &str) -> Result<String, String> {
    let name = Path::new(file);
    let inside = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let path = folder.join(name);
    let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let real = |path: &Path| path.canonicalize();
    let outside = || "lies outside the model's folder, where nothing is read".to_owned();
    if !inside {
        return Err(outside());
    }
    match (real(root), real(&path)) {
        (Ok(root), Ok(path)) if path.starts_with(&root) => read_text(&path).map_err(|e| e.to_string()),
        (Ok(_), Ok(_)) => Err(outside()),
        (Err(e), _) | (_, Err(e)) => Err(format!("cannot be read: {e}")),
    }
}

/// Warnings on standard error, one per line.
pub(super) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        eprintln!("warning: {}", one_line(&warning.to_string()));
    }
}

/// A name to show and to refer to, also for what has none.
pub(super) fn display_name(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind}_{index}") } else { name.to_owned() }
}
