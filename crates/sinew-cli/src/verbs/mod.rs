//! One file per verb.

pub(crate) mod adapt;
pub(crate) mod arm;
pub(crate) mod bench;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod drive;
pub(crate) mod evaluate;
pub(crate) mod identify;
mod numeric_table;
pub(crate) mod predict;
pub(crate) mod reproduce;
pub(crate) mod tension;
pub(crate) mod track;
pub(crate) mod twin;

use crate::error::Error;
use sinew::predictor::Model;
use std::path::Path;

/// Largest model, robot or table that is read, MB; real ones have some ten kilobytes.
const MAX_FILE_MB: u64 = 64;

/// Reads a model file.
pub(crate) fn read_model(path: &Path) -> Result<Model, Error> {
    let text = read_text(path)?;
    Model::from_json(&text).map_err(|source| Error::Model { file: path.to_owned(), source: source.into() })
}

/// Text of a file of bounded size, without a byte order mark.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    let unreadable = |source| Error::Unreadable { file: path.to_owned(), source };
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    if size > MAX_FILE_MB << 20 {
        return Err(Error::TooLarge { file: path.to_owned(), size_mb: size >> 20, limit_mb: MAX_FILE_MB });
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text = String::from_utf8(bytes)
        .map_err(|e| Error::NotText { file: path.to_owned(), source: e.utf8_error() })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
