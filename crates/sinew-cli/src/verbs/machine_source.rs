//! A machine together with the texts of its files, so that it can be read again where the files are gone.

use crate::error::Error;
use serde::{Deserialize, Serialize};
use sinew::description::machine::FileReference;
use sinew::description::machine::machine_on_bus;
use sinew::description::{MachineDescription, from_mjcf, from_osim, from_urdf, machine_of};
use sinew_lab::machine_file::{
    Format, MachineFileError, beside, built_in, include, load_machine_on, muscles_of, read_text,
};
use sinew_runtime::{DeviceTables, Devices};
use std::path::{Path, PathBuf};

/// Text of a file, with what it is to the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SourceText {
    /// [`MAIN`], [`MUSCLES`], or the path of a file with that of the one that names it.
    pub(crate) role: String,
    pub(crate) text: String,
}

/// Roles of the machine's or robot's own file, and of a URDF robot's muscles.
pub(crate) const MAIN: &str = "main";
const MUSCLES: &str = "muscles";

/// A machine as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MachineSource {
    /// Path of the file as given.
    pub(crate) path: PathBuf,
    /// Of all its files, [`MAIN`] first.
    pub(crate) texts: Vec<SourceText>,
    /// Folder in which the files lie that its body names; of files that are read again it has no use.
    #[serde(skip)]
    pub(crate) root: Option<PathBuf>,
}

/// Gives the text of a role; `read` reads it from the disk.
type Texts<'a> = dyn FnMut(String, &mut dyn FnMut() -> Result<String, String>) -> Result<String, String> + 'a;

/// A machine, what identifies its devices, and the texts that it was read from.
pub(crate) struct Loaded {
    pub(crate) described: MachineDescription,
    pub(crate) devices: Devices,
    pub(crate) source: MachineSource,
}

/// Reads and validates a machine, and what identifies its devices.
pub(crate) fn load_machine(
    path: &Path,
    muscles: Option<&Path>,
    root: Option<&Path>,
) -> Result<(MachineDescription, Devices), Error> {
    let mut tables = DeviceTables::default();
    let mut described = load_machine_on(path, muscles, root, &mut tables)?;
    let devices = tables.devices(&mut described.machine)?;
    Ok((described, devices))
}

/// The same with the texts of all its files.
pub(crate) fn load(path: &Path, root: Option<&Path>) -> Result<Loaded, Error> {
    let text = match built_in(path) {
        Some((_, text)) => text.to_owned(),
        None => {
            Format::from_path(path)?;
            read_text(path).map_err(MachineFileError::from)?
        }
    };
    let mut texts = vec![SourceText { role: MAIN.to_owned(), text: text.clone() }];
    let (described, devices) = build(path, &text, root, &mut |role, read| {
        let text = read()?;
        texts.push(SourceText { role, text: text.clone() });
        Ok(text)
    })?;
    let source = MachineSource { path: path.to_owned(), texts, root: root.map(Path::to_owned) };
    Ok(Loaded { described, devices, source })
}

impl MachineSource {
    fn text(&self, role: &str) -> Option<&str> {
        self.texts.iter().find(|text| text.role == role).map(|text| text.text.as_str())
    }

    /// Hash of all its texts (FNV-1a, 64 bits): another one is another machine.
    pub(crate) fn hash(&self) -> String {
        let bytes = self.texts.iter().flat_map(|text| text.role.bytes().chain([0]).chain(text.text.bytes()));
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}")
    }

    /// Reads and validates the machine from its texts alone.
    pub(crate) fn machine(&self) -> Result<MachineDescription, Error> {
        let main = self.text(MAIN).unwrap_or_default();
        let (described, _) = build(&self.path, main, None, &mut |role, _| {
            self.text(&role).map(str::to_owned).ok_or_else(|| "is not part of the recording".to_owned())
        })?;
        Ok(described)
    }
}

fn role_of(file: &FileReference<'_>) -> String {
    file.included_by.map_or_else(|| file.path.to_owned(), |by| format!("{} in {by}", file.path))
}

fn build(
    path: &Path,
    text: &str,
    root: Option<&Path>,
    texts: &mut Texts<'_>,
) -> Result<(MachineDescription, Devices), Error> {
    let name = path.display().to_string();
    let mut tables = DeviceTables::default();
    let mut described = match Format::from_path(path) {
        Ok(Format::Urdf) => {
            let mut muscles = None;
            let file = muscles_of(path, None);
            let name_of_file = file.as_ref().map_or_else(String::new, |file| file.display().to_string());
            let mut read = || match &file {
                Some(file) => read_text(file).map_err(|error| error.to_string()),
                None => Err(String::new()),
            };
            // A robot without muscles is refused by its own message.
            if let Ok(found) = texts(MUSCLES.to_owned(), &mut read) {
                muscles = Some(found);
            }
            let muscles = muscles.as_deref().map(|text| (name_of_file.as_str(), text));
            machine_of(from_urdf(&name, text, muscles)?)?
        }
        Ok(Format::Osim) => machine_of(from_osim(&name, text)?)?,
        Ok(Format::Mjcf) => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            let mut read = |file: &str| texts(file.to_owned(), &mut || include(&folder, file, root));
            machine_of(from_mjcf(&name, text, &mut read)?)?
        }
        Ok(Format::Toml) | Err(_) => {
            let mut read = |file: FileReference<'_>| {
                let role = role_of(&file);
                texts(role, &mut || beside(path, FileReference { ..file }, root))
            };
            machine_on_bus(&name, text, &mut read, &mut tables)?
        }
    };
    let devices = tables.devices(&mut described.machine)?;
    Ok((described, devices))
}
