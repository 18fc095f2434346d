//! A model as C99: one header, one source, an example and what other tools need beside them.
//!
//! The templates hold the laws once more, in C; that they stay those of the library is a test that compares
//! every bit of both over random models and samples.

mod example;
mod integrations;
mod laws;
mod literal;
mod networks;
mod source;
mod template;

pub(crate) use literal::double;
pub(crate) use source::checksum;
pub(crate) use template::Filling;

use crate::{ExportError, ExportedFile, Name};
use sinew::predictor::Model;

/// Header and source of a model's predictor.
///
/// # Errors
/// As [`Model::validate`].
pub fn library(model: &Model, name: &Name) -> Result<[ExportedFile; 2], ExportError> {
    model.validate()?;
    let (header, source) = source::generate(model, name)?;
    let file = |suffix: &str, text| ExportedFile::text(format!("{}.{suffix}", name.as_str()), text);
    Ok([file("h", header), file("c", source)])
}

/// Every file of the export: the predictor, a program that runs it over a log, and what CMake, Simulink and
/// Arduino need.
///
/// # Errors
/// As [`Model::validate`].
pub fn files(model: &Model, name: &Name) -> Result<Vec<ExportedFile>, ExportError> {
    let mut files = Vec::from(library(model, name)?);
    files.push(example::file(model, name));
    files.extend(integrations::files(model, name));
    Ok(files)
}
