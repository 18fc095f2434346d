//! Machines and robots from files (TOML, MJCF, URDF, OpenSim) or by the names of those that come with the
//! program.

mod error;
mod mesh;
mod root;
mod text;

pub use error::MachineFileError;
pub use mesh::mesh_bytes;
pub use root::found;
pub use text::{TextFileError, read_text};

use sinew::body::Robot;
use sinew::description::machine::{BusReader, FileReference, has_machine_keys, machine_on_bus};
use sinew::description::{
    Description, MachineDescription, Warning, from_mjcf, from_osim, from_urdf, machine_from_toml, machine_of,
    robot_from_toml,
};
use sinew_models::MACHINES;
use std::path::{Path, PathBuf};

/// A valid robot and the warnings of its description.
#[derive(Debug, Clone)]
pub struct LoadedRobot {
    /// The robot.
    pub robot: Robot,
    /// What its file says and this program leaves out.
    pub warnings: Vec<Warning>,
}

/// Reads and validates a machine: a machine file, or a robot file with defaults for everything but the body.
/// A file takes precedence over a built-in machine of the same name; `muscles` is as in [`load_robot`]. What
/// identifies its devices on their bus is left out: see [`load_machine_on`], which also has a `root`.
///
/// # Errors
/// [`MachineFileError`] names the file, the place in it and what was expected.
pub fn load_machine(path: &Path, muscles: Option<&Path>) -> Result<MachineDescription, MachineFileError> {
    match text_of(path, muscles, None)? {
        Text::Toml { name, text } => {
            Ok(machine_from_toml(&name, &text, &mut |file| beside(path, file, None))?)
        }
        Text::Other(description) => Ok(machine_of(*description)?),
    }
}

/// As [`load_machine`], with what identifies its devices on a bus; the files that its body names lie in the
/// [root](found).
///
/// # Errors
/// As [`load_machine`], and those of the bus.
pub fn load_machine_on(
    path: &Path,
    muscles: Option<&Path>,
    root: Option<&Path>,
    bus: &mut dyn BusReader,
) -> Result<MachineDescription, MachineFileError> {
    match text_of(path, muscles, root)? {
        Text::Toml { name, text } => {
            Ok(machine_on_bus(&name, &text, &mut |file| beside(path, file, root), bus)?)
        }
        Text::Other(description) => Ok(machine_of(*description)?),
    }
}

/// Reads and validates a robot: a robot file, or the body of a machine file; a file takes precedence over a
/// built-in machine of the same name.
///
/// `muscles` is a TOML file with the muscles of a URDF robot, because URDF has none. By default it is
/// `NAME.muscles.toml` beside `NAME.urdf`, where that exists. Other robots contain their muscles: with them
/// `muscles` is an error. The files that it names lie in the [root](found).
///
/// # Errors
/// As [`load_machine`].
pub fn load_robot(
    path: &Path,
    muscles: Option<&Path>,
    root: Option<&Path>,
) -> Result<LoadedRobot, MachineFileError> {
    let (robot, warnings) = match text_of(path, muscles, root)? {
        Text::Toml { name, text } => robot_from_toml(&name, &text, &mut |file| beside(path, file, root))?,
        Text::Other(description) => description.robot()?,
    };
    Ok(LoadedRobot { robot, warnings })
}

/// Reads and validates the text of a machine file that is to stand at `path`.
///
/// # Errors
/// As [`load_machine`].
pub fn machine_in(
    path: &Path,
    text: &str,
    root: Option<&Path>,
) -> Result<MachineDescription, MachineFileError> {
    Ok(machine_from_toml(&path.display().to_string(), text, &mut |file| beside(path, file, root))?)
}

/// Whether a file describes a robot alone or a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A robot alone; for URDF with the file of its muscles.
    Robot {
        /// The file of the muscles of a URDF robot.
        muscles: Option<PathBuf>,
    },
    /// A machine, of a file or built in.
    Machine,
}

/// Whether a file, or a built-in name, describes a robot alone or a machine.
///
/// # Errors
/// As [`load_machine`].
pub fn source_of(
    path: &Path,
    muscles: Option<&Path>,
    root: Option<&Path>,
) -> Result<Source, MachineFileError> {
    match (text_of(path, muscles, root)?, Format::from_path(path)) {
        (Text::Toml { name, text }, Ok(Format::Toml)) if !has_machine_keys(&name, &text)? => {
            Ok(Source::Robot { muscles: None })
        }
        (Text::Toml { .. }, _) => Ok(Source::Machine),
        (Text::Other(_), Ok(Format::Urdf)) => Ok(Source::Robot { muscles: muscles_of(path, muscles) }),
        (Text::Other(_), _) => Ok(Source::Robot { muscles: None }),
    }
}

/// The file of a URDF robot's muscles: the one that is given, or the one beside it.
#[must_use]
pub fn muscles_of(path: &Path, muscles: Option<&Path>) -> Option<PathBuf> {
    let beside = path.with_extension("muscles.toml");
    muscles.map(Path::to_owned).or_else(|| beside.exists().then_some(beside))
}

/// A file after the steps that [`load_machine`] and [`load_robot`] have in common.
enum Text {
    /// A machine file or a robot file.
    Toml {
        /// Of the file or the built-in machine, for errors.
        name: String,
        text: String,
    },
    /// A robot in another format, not yet validated.
    Other(Box<Description>),
}

/// Name and text of a machine that comes with the program, where no file has its name.
#[must_use]
pub fn built_in(path: &Path) -> Option<(&'static str, &'static str)> {
    MACHINES.iter().find(|(name, _)| path.as_os_str() == *name && !path.exists()).copied()
}

fn text_of(path: &Path, muscles: Option<&Path>, root: Option<&Path>) -> Result<Text, MachineFileError> {
    let built_in = built_in(path);
    if built_in.is_some() && muscles.is_some() {
        return Err(MachineFileError::MusclesTwice { file: path.to_owned() });
    }
    if let Some((name, text)) = built_in {
        return Ok(Text::Toml { name: (*name).to_owned(), text: (*text).to_owned() });
    }
    let format = Format::from_path(path)?;
    let text = read_text(path)?;
    let name = path.display().to_string();
    if muscles.is_some() && format != Format::Urdf {
        return Err(MachineFileError::MusclesTwice { file: path.to_owned() });
    }
    match format {
        Format::Toml => Ok(Text::Toml { name, text }),
        Format::Urdf => {
            let text_of = muscles_of(path, muscles)
                .map(|file| Ok::<_, MachineFileError>((file.display().to_string(), read_text(&file)?)))
                .transpose()?;
            let muscles = text_of.as_ref().map(|(name, text)| (name.as_str(), text.as_str()));
            Ok(Text::Other(Box::new(from_urdf(&name, &text, muscles)?)))
        }
        Format::Osim => Ok(Text::Other(Box::new(from_osim(&name, &text)?))),
        Format::Mjcf => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            let description = from_mjcf(&name, &text, &mut |file| include(&folder, file, root))?;
            Ok(Text::Other(Box::new(description)))
        }
    }
}

/// Text of a file that the machine file at `path` names, or the reason why it cannot be read.
///
/// # Errors
/// The reason.
pub fn beside(path: &Path, file: FileReference<'_>, root: Option<&Path>) -> Result<String, String> {
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
    match file.included_by {
        Some(body) => {
            let body = folder.join(body);
            include(&body.parent().map_or_else(PathBuf::new, Path::to_owned), file.path, root)
        }
        None => read_text(&folder.join(file.path)).map_err(|error| error.to_string()),
    }
}

/// File format of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// This program's own format.
    Toml,
    /// XML of the simulator MuJoCo.
    Mjcf,
    /// Unified Robot Description Format of ROS.
    Urdf,
    /// A model of OpenSim.
    Osim,
}

impl Format {
    /// The format that the extension denotes.
    ///
    /// # Errors
    /// [`MachineFileError::Format`] for any other.
    pub fn from_path(path: &Path) -> Result<Self, MachineFileError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("toml") => Ok(Self::Toml),
            Some("xml" | "mjcf") => Ok(Self::Mjcf),
            Some("urdf") => Ok(Self::Urdf),
            Some("osim") => Ok(Self::Osim),
            _ => Err(MachineFileError::Format { file: path.to_owned() }),
        }
    }
}

/// Text of a file that an MJCF model includes, or the reason why it cannot be read: it lies in the model's
/// [root](found). Of a mesh its triangles.
///
/// # Errors
/// The reason.
pub fn include(folder: &Path, file: &str, root: Option<&Path>) -> Result<String, String> {
    if mesh::is_mesh(file) {
        return mesh::mesh_text(folder, file, root);
    }
    if root.is_none() && Path::new(file).is_absolute() {
        return Err("is an absolute path: expected one from the model's folder".to_owned());
    }
    read_text(&found(folder, Path::new(file), root)?).map_err(|e| e.to_string())
}
