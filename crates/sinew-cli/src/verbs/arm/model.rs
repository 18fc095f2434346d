//! Loading a robot from a file (TOML, MJCF or URDF) or by the name of a built-in one.

use crate::error::Error;
use crate::output::one_line;
use crate::verbs::read_text;
use sinew::body::Robot;
use sinew::description::{Description, Warning, from_mjcf, from_toml, from_urdf};
use std::path::{Component, Path, PathBuf};

/// Built-in robots: name, and file in this program's TOML format.
const BUILT_IN: [(&str, &str); 1] = [("lm_arm", include_str!("../../../../../models/lm_arm.toml"))];

/// A valid robot and the warnings of its description.
pub(in crate::verbs) struct Loaded {
    pub(in crate::verbs) robot: Robot,
    pub(in crate::verbs) warnings: Vec<Warning>,
}

/// Reads and validates a robot; a file takes precedence over a built-in robot of the same name.
///
/// `muscles` is a TOML file with the muscles of a URDF robot, because URDF has none. By default it is
/// `NAME.muscles.toml` beside `NAME.urdf`, where that exists. Other robots contain their muscles: with them
/// `muscles` is an error.
pub(in crate::verbs) fn load_robot(path: &Path, muscles: Option<&Path>) -> Result<Loaded, Error> {
    let (robot, warnings) = description(path, muscles)?.robot()?;
    Ok(Loaded { robot, warnings })
}

/// The robot as described, not yet validated.
fn description(path: &Path, muscles: Option<&Path>) -> Result<Description, Error> {
    let built_in = BUILT_IN.iter().find(|(name, _)| path.as_os_str() == *name && !path.exists());
    if built_in.is_some() && muscles.is_some() {
        return Err(Error::MusclesTwice { file: path.to_owned() });
    }
    if let Some((name, text)) = built_in {
        return Ok(from_toml(name, text)?);
    }
    let format = Format::of(path)?;
    let text = read_text(path)?;
    let name = path.display().to_string();
    if muscles.is_some() && format != Format::Urdf {
        return Err(Error::MusclesTwice { file: path.to_owned() });
    }
    match format {
        Format::Toml => Ok(from_toml(&name, &text)?),
        Format::Urdf => {
            let beside = path.with_extension("muscles.toml");
            let file = muscles.map(Path::to_owned).or_else(|| beside.exists().then_some(beside));
            let text_of = file
                .map(|file| Ok::<_, Error>((file.display().to_string(), read_text(&file)?)))
                .transpose()?;
            Ok(from_urdf(&name, &text, text_of.as_ref().map(|(name, text)| (name.as_str(), text.as_str())))?)
        }
        Format::Mjcf => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            Ok(from_mjcf(&name, &text, &mut |file| include(&folder, file))?)
        }
    }
}

/// File format of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// This program's own format.
    Toml,
    /// XML of the simulator MuJoCo.
    Mjcf,
    /// Unified Robot Description Format of ROS.
    Urdf,
}

impl Format {
    /// The format that the extension denotes.
    pub(super) fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("toml") => Ok(Self::Toml),
            Some("xml" | "mjcf") => Ok(Self::Mjcf),
            Some("urdf") => Ok(Self::Urdf),
            _ => Err(Error::RobotFormat {
                file: path.to_owned(),
                expected: ".toml, .xml or .urdf, or the name of a built-in robot (lm_arm)",
            }),
        }
    }
}

/// Text of a file that an MJCF model includes, or the reason why it cannot be read: only files within the
/// model's folder are read, also after symbolic links are resolved.
fn include(folder: &Path, file: &str) -> Result<String, String> {
    let name = Path::new(file);
    let inside = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let path = folder.join(name);
    let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let real = |path: &Path| path.canonicalize();
    let outside = || "lies outside the model's folder: expected a file within it".to_owned();
    if !inside {
        return Err(outside());
    }
    match (real(root), real(&path)) {
        (Ok(root), Ok(path)) if path.starts_with(&root) => read_text(&path).map_err(|e| e.to_string()),
        (Ok(_), Ok(_)) => Err(outside()),
        (Err(e), _) | (_, Err(e)) => Err(format!("cannot be read: {e}")),
    }
}

/// Prints warnings on standard error, one per line.
pub(super) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        eprintln!("warning: {}", one_line(&warning.to_string()));
    }
}

/// The name of a part; a generated one where it has none.
pub(super) fn display_name(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind}_{index}") } else { name.to_owned() }
}
