//! The sources of a unit, which importers compile.

use super::variables::Interface;
use crate::c::{self, Content, Filling, double};
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

/// The header and source of the C, and the interface around them.
///
/// # Errors
/// As [`c::library`].
pub fn sources(
    model: &Model,
    name: &Name,
    content: Content,
    version: Version,
) -> Result<Vec<ExportedFile>, ExportError> {
    let mut files = Vec::from(c::library(model, name, content)?);
    let interface = Interface::new(model, content);
    let mut filling = Filling::default();
    let starts: Vec<String> = interface.starts().into_iter().map(double).collect();
    filling.set("starts", starts.join(", "));
    filling.set("token", interface.token()?);
    filling.set("numbers", interface.numbers.len());
    filling.set("flags", interface.flags.len());
    filling.when("inverse", interface.near.is_some());
    filling.set("near", interface.near.unwrap_or_default());
    files.push(ExportedFile::text("core.h", filling.render(CORE, name)));
    let stem = version.stem();
    files.push(ExportedFile::text(format!("{stem}.c"), filling.render(version.template(), name)));
    Ok(files)
}
