//! One file per verb.

pub(crate) mod adapt;
mod beside_file;
pub(crate) mod calibrate;
pub(crate) mod can;
mod columns;
pub(crate) mod compensate;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod design;
mod device_files;
pub(crate) mod doctor;
pub(crate) mod ethercat;
pub(crate) mod evaluate;
pub(crate) mod example;
pub(crate) mod export;
pub(crate) mod identify;
pub(crate) mod link;
pub(crate) mod live;
pub(crate) mod log;
pub(crate) mod machine;
pub(crate) mod machine_source;
pub(crate) mod man;
pub(crate) mod meshes;
mod numeric_table;
mod page;
pub(crate) mod predict;
pub(crate) mod recording;
pub(crate) mod reproduce;
pub(crate) mod run;
pub(crate) mod servos;
mod simulated_arm;
pub(crate) mod track;
pub(crate) mod twin;
mod verification;

use crate::error::Error;
use sinew::predictor::Model;
use std::path::Path;

/// Reads a model file.
pub(crate) fn read_model(path: &Path) -> Result<Model, Error> {
    let text = read_text(path)?;
    Model::from_json(&text).map_err(|source| Error::Model { file: path.to_owned(), source: source.into() })
}

/// Text of a file of bounded size, without a byte order mark.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    Ok(sinew_lab::machine_file::read_text(path)?)
}
