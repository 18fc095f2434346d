//! Loading a machine or a robot from a file (TOML, MJCF or URDF) or by the name of a built-in one.

use crate::error::Error;
use crate::output::one_line;
use crate::verbs::read_text;
use sinew::body::Robot;
use sinew::description::machine::{FileReference, has_machine_keys};
use sinew::description::{
    Description, MachineDescription, Warning, from_mjcf, from_urdf, machine_from_toml, machine_of,
    robot_from_toml,
};
use std::path::{Component, Path, PathBuf};

/// Built-in machines: name and file.
const BUILT_IN: [(&str, &str); 8] = [
    ("lm_arm", include_str!("../../../../../models/lm_arm.toml")),
    ("bench_joint", include_str!("../../../../../models/bench_joint.toml")),
    ("planar_leg", include_str!("../../../../../models/planar_leg.toml")),
    ("finger", include_str!("../../../../../models/finger.toml")),
    ("exosuit_elbow", include_str!("../../../../../models/exosuit_elbow.toml")),
    ("surgical_wrist", include_str!("../../../../../models/surgical_wrist.toml")),
    ("shoulder", include_str!("../../../../../models/shoulder.toml")),
    ("chain10", include_str!("../../../../../models/chain10.toml")),
];

/// A valid robot and the warnings of its description.
pub(in crate::verbs) struct Loaded {
    pub(in crate::verbs) robot: Robot,
    pub(in crate::verbs) warnings: Vec<Warning>,
}

/// A valid machine, the origin of its values, and the warnings of its description.
pub(in crate::verbs) type LoadedMachine = MachineDescription;

/// Reads and validates a machine: a machine file, or a robot file with defaults for everything but the body. A
/// file takes precedence over a built-in machine of the same name; `muscles` is as in [`load_robot`].
pub(in crate::verbs) fn load_machine(path: &Path, muscles: Option<&Path>) -> Result<LoadedMachine, Error> {
    match text_of(path, muscles)? {
        Text::Toml { name, text } => Ok(machine_from_toml(&name, &text, &mut |file| beside(path, file))?),
        Text::Other(description) => Ok(machine_of(*description)?),
    }
}

/// Reads and validates a robot: a robot file, or the body of a machine file; a file takes precedence over a
/// built-in machine of the same name.
///
/// `muscles` is a TOML file with the muscles of a URDF robot, because URDF has none. By default it is
/// `NAME.muscles.toml` beside `NAME.urdf`, where that exists. Other robots contain their muscles: with them
/// `muscles` is an error.
pub(in crate::verbs) fn load_robot(path: &Path, muscles: Option<&Path>) -> Result<Loaded, Error> {
    let (robot, warnings) = match text_of(path, muscles)? {
        Text::Toml { name, text } => robot_from_toml(&name, &text, &mut |file| beside(path, file))?,
        Text::Other(description) => description.robot()?,
    };
    Ok(Loaded { robot, warnings })
}

/// Reads and validates the text of a machine file that is to stand at `path`.
pub(in crate::verbs) fn machine_in(path: &Path, text: &str) -> Result<LoadedMachine, Error> {
    Ok(machine_from_toml(&path.display().to_string(), text, &mut |file| beside(path, file))?)
}

/// Whether a file describes a robot alone.
pub(in crate::verbs) enum Source {
    /// Yes; for URDF with the file of its muscles.
    Robot { muscles: Option<PathBuf> },
    /// No: it is a machine file, or built in.
    Machine,
}

/// What a file describes.
pub(in crate::verbs) fn source_of(path: &Path, muscles: Option<&Path>) -> Result<Source, Error> {
    match (text_of(path, muscles)?, Format::of(path)) {
        (Text::Toml { name, text }, Ok(Format::Toml)) if !has_machine_keys(&name, &text)? => {
            Ok(Source::Robot { muscles: None })
        }
        (Text::Toml { .. }, _) => Ok(Source::Machine),
        (Text::Other(_), Ok(Format::Urdf)) => Ok(Source::Robot { muscles: muscles_of(path, muscles) }),
        (Text::Other(_), _) => Ok(Source::Robot { muscles: None }),
    }
}

/// The file of a URDF robot's muscles.
fn muscles_of(path: &Path, muscles: Option<&Path>) -> Option<PathBuf> {
    let beside = path.with_extension("muscles.toml");
    muscles.map(Path::to_owned).or_else(|| beside.exists().then_some(beside))
}

/// A file as far as both readers treat it alike.
enum Text {
    /// A machine file or a robot file.
    Toml {
        /// For errors.
        name: String,
        text: String,
    },
    /// A robot in another format, not yet validated.
    Other(Box<Description>),
}

fn text_of(path: &Path, muscles: Option<&Path>) -> Result<Text, Error> {
    let built_in = BUILT_IN.iter().find(|(name, _)| path.as_os_str() == *name && !path.exists());
    if built_in.is_some() && muscles.is_some() {
        return Err(Error::MusclesTwice { file: path.to_owned() });
    }
    if let Some((name, text)) = built_in {
        return Ok(Text::Toml { name: (*name).to_owned(), text: (*text).to_owned() });
    }
    let format = Format::of(path)?;
    let text = read_text(path)?;
    let name = path.display().to_string();
    if muscles.is_some() && format != Format::Urdf {
        return Err(Error::MusclesTwice { file: path.to_owned() });
    }
    match format {
        Format::Toml => Ok(Text::Toml { name, text }),
        Format::Urdf => {
            let text_of = muscles_of(path, muscles)
                .map(|file| Ok::<_, Error>((file.display().to_string(), read_text(&file)?)))
                .transpose()?;
            let muscles = text_of.as_ref().map(|(name, text)| (name.as_str(), text.as_str()));
            Ok(Text::Other(Box::new(from_urdf(&name, &text, muscles)?)))
        }
        Format::Mjcf => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            let description = from_mjcf(&name, &text, &mut |file| include(&folder, file))?;
            Ok(Text::Other(Box::new(description)))
        }
    }
}

/// Text of a file that the machine file at `path` names, or the reason why it cannot be read.
fn beside(path: &Path, file: FileReference<'_>) -> Result<String, String> {
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
    match file.included_by {
        Some(body) => {
            let body = folder.join(body);
            include(&body.parent().map_or_else(PathBuf::new, Path::to_owned), file.path)
        }
        None => read_text(&folder.join(file.path)).map_err(|error| error.to_string()),
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
                expected: ".toml, .xml or .urdf, or the name of a built-in machine (lm_arm, bench_joint, planar_leg, finger, \
                           exosuit_elbow, surgical_wrist, shoulder, chain10)",
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
pub(in crate::verbs) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        eprintln!("warning: {}", one_line(&warning.to_string()));
    }
}

/// The name of a part; a generated one where it has none.
pub(super) fn display_name(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind}_{index}") } else { name.to_owned() }
}
