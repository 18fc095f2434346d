//! One file per verb.

pub(crate) mod adapt;
pub(crate) mod arm;
pub(crate) mod bench;
pub(crate) mod demo;
pub(crate) mod drive;
pub(crate) mod evaluate;
pub(crate) mod identify;
mod numeric_table;
pub(crate) mod predict;
pub(crate) mod reproduce;
mod specimen;
pub(crate) mod tension;
pub(crate) mod track;
pub(crate) mod twin;

use crate::error::Error;
use sinew::predictor::{Model, ModelFileError};
use std::path::Path;

/// Largest file of a model, a robot or problems that is read; real ones have some ten thousand bytes.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// Reads a model file.
pub(crate) fn read_model(path: &Path) -> Result<Model, Error> {
    let unreadable = |source| Error::Unreadable { file: path.to_owned(), source };
    let refused = |name: &str, expected: &str, got: String| Error::Model {
        file: path.to_owned(),
        source: Box::new(ModelFileError { name: name.into(), expected: expected.into(), got }),
    };
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    if size > MAX_FILE_BYTES {
        return Err(refused("file", "at most 64 MB", format!("{} MB", size >> 20)));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text = String::from_utf8(bytes)
        .map_err(|e| refused("file", "text (JSON)", format!("bytes that are no text: {}", e.utf8_error())))?;
    Model::from_json(&text).map_err(|source| Error::Model { file: path.to_owned(), source: source.into() })
}

/// Text of a file of bounded size.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    let unreadable = |source| Error::Unreadable { file: path.to_owned(), source };
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    let refused = |problem: String| Error::File { file: path.to_owned(), problem };
    if size > MAX_FILE_BYTES {
        return Err(refused(format!("has {} MB: expected at most 64 MB", size >> 20)));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text =
        String::from_utf8(bytes).map_err(|e| refused(format!("is no text (UTF-8): {}", e.utf8_error())))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
