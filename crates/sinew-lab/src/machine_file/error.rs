use super::text::TextFileError;
use sinew::description::DescriptionError;
use std::path::PathBuf;

/// A machine or robot file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MachineFileError {
    /// Its text, or that of its muscles, cannot be read.
    #[error(transparent)]
    Text(#[from] TextFileError),
    /// Muscles beside a robot file that has muscles of its own.
    #[error("{}: contains its muscles: expected muscles beside a .urdf file only", file.display())]
    MusclesTwice {
        /// The robot's file.
        file: PathBuf,
    },
    /// The extension names no format, and the whole is no built-in machine.
    #[error(
        "{}: expected a machine or robot file ending in .toml, .xml, .urdf or .osim, or the name of a built-in \
            machine ({})",
        file.display(),
        sinew_models::MACHINES.map(|(name, _)| name).join(", ")
    )]
    Format {
        /// The file.
        file: PathBuf,
    },
    /// Its content describes no valid machine or robot.
    #[error(transparent)]
    Description(Box<DescriptionError>),
}

impl From<DescriptionError> for MachineFileError {
    fn from(error: DescriptionError) -> Self {
        Self::Description(Box::new(error))
    }
}
