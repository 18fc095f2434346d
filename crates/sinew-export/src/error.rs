//! What cannot be exported.

use std::path::PathBuf;

/// Why an export was refused; nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A model outside its domain.
    #[error(transparent)]
    Model(#[from] sinew::predictor::ModelFileError),
    /// A compensator that cannot be made of the model.
    #[error(transparent)]
    Compensator(#[from] sinew::compensator::CompensatorError),
    /// A name that the generated code cannot carry.
    #[error("name `{name}`: expected {expected}")]
    Name {
        /// As given.
        name: String,
        /// What would do.
        expected: &'static str,
    },
    /// What has no graph in ONNX.
    #[error(
        "ONNX: expected predictions by clamp cells, regressions, gated networks or sums of them, got {what}"
    )]
    Onnx {
        /// The part of the model, or what was asked of it.
        what: &'static str,
    },
    /// A C compiler that does not compile the sources of a unit.
    #[error("{}: {reason}", compiler.display())]
    Compiler {
        /// The program.
        compiler: PathBuf,
        /// What it said.
        reason: String,
    },
    /// An archive that cannot be made.
    #[error("archive: {0}")]
    Archive(String),
}
