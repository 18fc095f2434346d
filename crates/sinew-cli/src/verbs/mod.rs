//! One file per verb.

pub(crate) mod adapt;
pub(crate) mod arm;
pub(crate) mod bench;
mod columns;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod drive;
pub(crate) mod ethercat;
pub(crate) mod evaluate;
pub(crate) mod identify;
pub(crate) mod link;
pub(crate) mod machine;
pub(crate) mod man;
mod numeric_table;
pub(crate) mod plot;
pub(crate) mod predict;
pub(crate) mod reproduce;
pub(crate) mod run;
pub(crate) mod tension;
pub(crate) mod track;
pub(crate) mod twin;

use crate::error::Error;
use sinew::predictor::Model;
use std::io::Read;
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
    let limit = MAX_FILE_MB << 20;
    let mut bytes = Vec::new();
    // Bounded while it is read: a device or a pipe has no size beforehand.
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(Error::TooLarge { file: path.to_owned(), limit_mb: MAX_FILE_MB });
    }
    let text = String::from_utf8(bytes)
        .map_err(|e| Error::NotText { file: path.to_owned(), source: e.utf8_error() })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
