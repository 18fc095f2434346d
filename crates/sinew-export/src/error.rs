//! What cannot be exported.

use std::io;
use std::path::PathBuf;

/// Why an export was refused; nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A model outside its domain.
    #[error(transparent)]
    Model(#[from] sinew::predictor::ModelFileError),
    /// A name that the generated code cannot carry.
    #[error("name `{name}`: expected {expected}")]
    Name {
        /// As given.
        name: String,
        /// What would do.
        expected: &'static str,
    },
    /// A place that cannot be written.
    #[error("{}: {source}", file.display())]
    Unwritable {
        /// The file or folder.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
}
