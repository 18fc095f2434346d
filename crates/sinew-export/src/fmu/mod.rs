//! Functional mock-up units for co-simulation around the exported C: FMI 3.0 and 2.0.

mod binary;
mod description;
mod sources;
mod variables;
mod zip;

pub use binary::{PLATFORM, compile};
pub use sources::{Version, sources};

use crate::c::Content;
use crate::{ExportError, ExportedFile, Name};
use sinew::predictor::Model;

/// `NAME.fmu`: description, sources, and the binary of [`compile`] where there is one.
///
/// # Errors
/// As [`sources`].
pub fn file(
    model: &Model,
    name: &Name,
    content: Content,
    version: Version,
    binary: Option<&[u8]>,
) -> Result<ExportedFile, ExportError> {
    let sources = sources(model, name, content, version)?;
    let mut entries = vec![ExportedFile::text(
        "modelDescription.xml",
        description::model_description(model, name, content, version)?,
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
