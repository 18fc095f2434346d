//! Functional mock-up units for co-simulation around the exported C: FMI 3.0 and 2.0.

mod binary;
mod description;
mod variables;
mod zip;

pub use binary::{PLATFORM, compile};

use crate::c::{self, Filling};
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
    fn stem(self) -> &'static str {
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

/// `NAME.fmu`: description, sources, and the binary of [`compile`] where there is one.
///
/// # Errors
/// As [`Model::validate`].
pub fn file(
    model: &Model,
    name: &Name,
    version: Version,
    binary: Option<&[u8]>,
) -> Result<ExportedFile, ExportError> {
    let sources = sources(model, name, version)?;
    let mut entries = vec![ExportedFile::text(
        "modelDescription.xml",
        description::model_description(model, name, version)?,
    )];
    if version == Version::Three {
        entries
            .push(ExportedFile::text("sources/buildDescription.xml", description::build_description(name)));
    }
    entries.extend(sources.into_iter().map(|s| ExportedFile { path: format!("sources/{}", s.path), ..s }));
    if let Some(bytes) = binary {
        let path = format!("binaries/{}", binary::place(name, version));
        entries.push(ExportedFile { path, bytes: bytes.to_vec() });
    }
    Ok(ExportedFile { path: format!("{}.fmu", name.as_str()), bytes: zip::archive(&entries)? })
}

/// The sources of a unit.
fn sources(model: &Model, name: &Name, version: Version) -> Result<Vec<ExportedFile>, ExportError> {
    let mut filling = Filling::default();
    filling.set("starts", variables::starts(model).join(", "));
    filling.set("token", variables::token(model)?);
    let mut files = Vec::from(c::library(model, name)?);
    files.push(ExportedFile::text("core.h", filling.render(CORE, name)));
    let stem = version.stem();
    files.push(ExportedFile::text(format!("{stem}.c"), filling.render(version.template(), name)));
    Ok(files)
}
