//! Identified models for programs that are not written in Rust: C99 sources, functional mock-up units, ONNX.
//!
//! C and units give the bits of [`Predictor`](sinew::predictor::Predictor): the generator evaluates `exp`
//! and `log` of the parameters, writes the constants as hexadecimal literals, and the generated code
//! contains additions, multiplications, divisions, comparisons and square roots alone.
//!
//! ```text
//! Model ──> c::files ──> NAME.h, NAME.c, example.c, CMakeLists.txt, simulink/, arduino/
//!       ├─> fmu::Unit ─> NAME.fmu: modelDescription.xml, sources/, binaries/
//!       └─> onnx::file > NAME.onnx: one sample, with the state as an input and an output
//! ```
//!
//! Exports are files in memory; only [`fmu::Unit::compile`] calls a compiler, in a temporary folder.

pub mod c;
mod error;
pub mod fmu;
mod name;
pub mod onnx;

pub use error::ExportError;
pub use name::Name;

/// A file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// Path below the export's folder, with `/` between its parts.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl ExportedFile {
    /// A file of text.
    pub(crate) fn text(path: impl Into<String>, text: String) -> Self {
        Self { path: path.into(), bytes: text.into_bytes() }
    }
}
