//! A model as C99: one header, one source, an example and what other tools need beside them.
//!
//! The templates hold the laws once more, in C; that they stay those of the library is a test that compares
//! every bit of both over random models and samples.

mod content;
mod example;
mod integrations;
mod inverse;
mod laws;
mod literal;
mod members;
mod needs;
mod networks;
mod source;
mod specimen;
mod template;

pub use content::Content;
pub(crate) use literal::double;
pub(crate) use source::checksum;
pub(crate) use template::Filling;

use crate::{ExportError, ExportedFile, Name};
use sinew::predictor::Model;

/// Header and source of a model.
///
/// # Errors
/// As [`Model::validate`] and [`Compensator::new`](sinew::compensator::Compensator::new).
pub fn library(model: &Model, name: &Name, content: Content) -> Result<[ExportedFile; 2], ExportError> {
    model.validate()?;
    let (header, source) = source::generate(model, name, content)?;
    let file = |suffix: &str, text| ExportedFile::text(format!("{}.{suffix}", name.as_str()), text);
    Ok([file("h", header), file("c", source)])
}

/// Every file of the export: the sources, a program that runs them over a log, and what CMake, Simulink and
/// Arduino need.
///
/// # Errors
/// As [`library`].
pub fn files(model: &Model, name: &Name, content: Content) -> Result<Vec<ExportedFile>, ExportError> {
    let mut files = Vec::from(library(model, name, content)?);
    files.push(example::file(model, name, content));
    files.extend(integrations::files(model, name));
    Ok(files)
}
