//! The sources of a unit, which importers compile.

use super::variables::{starts, token};
use crate::c::{self, Content, Filling};
use crate::{ExportError, ExportedFile, Name};
use sinew::predictor::Model;

const CORE: &str = include_str!("templates/core.h");

/// Version of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// Stem of the source that implements it.
    pub(super) fn stem(self) -> &'static str {
        match self {
            Self::Two => "fmi2",
            Self::Three => "fmi3",
        }
    }

    fn template(self) -> &'static str {
        match self {
            Self::Two => include_str!("templates/fmi2.c"),
            Self::Three => include_str!("templates/fmi3.c"),
        }
    }
}

/// The predictor's header and source, and the interface around it.
///
/// # Errors
/// As [`Model::validate`].
pub fn sources(model: &Model, name: &Name, version: Version) -> Result<Vec<ExportedFile>, ExportError> {
    let mut filling = Filling::default();
    filling.set("starts", starts(model).join(", "));
    filling.set("token", token(model)?);
    let mut files = Vec::from(c::library(model, name, Content::Predictor)?);
    files.push(ExportedFile::text("core.h", filling.render(CORE, name)));
    let stem = version.stem();
    files.push(ExportedFile::text(format!("{stem}.c"), filling.render(version.template(), name)));
    Ok(files)
}
