//! The model file: JSON with format, version and checksum.

use super::model::Model;
use super::model_file_error::ModelFileError;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

/// Value of `format` in every model file.
const FORMAT: &str = "sinew transmission model";

/// Incremented with every change that an older program would misread.
pub const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    format: String,
    version: u32,
    /// CRC-32 of the text of `model`, hexadecimal.
    checksum: String,
    model: Box<RawValue>,
}

/// The fields that decide whether the rest is readable.
#[derive(Deserialize)]
struct Head {
    format: Option<String>,
    version: Option<u64>,
}

impl Model {
    /// The model as the text of a file. Every number survives the round trip bit for bit.
    ///
    /// # Errors
    /// As [`Model::validate`]: an invalid model is not written.
    pub fn to_json(&self) -> Result<String, ModelFileError> {
        self.validate()?;
        let refuse = |e: serde_json::Error| refusal("model", "numbers and names", e.to_string());
        let model = serde_json::value::to_raw_value(self).map_err(refuse)?;
        let checksum = checksum(model.get());
        let written = Written { format: FORMAT.to_string(), version: VERSION, checksum, model };
        serde_json::to_string(&written).map(|text| text + "\n").map_err(refuse)
    }

    /// Reads the text of a model file.
    ///
    /// # Errors
    /// [`ModelFileError`]: another kind of file, a newer version, a wrong checksum, or a value out of its
    /// domain.
    pub fn from_json(text: &str) -> Result<Self, ModelFileError> {
        let head: Head = serde_json::from_str(text).map_err(|e| {
            refusal("file", "a model made by `sinew identify`", format!("text that is no JSON object ({e})"))
        })?;
        match head.format.as_deref() {
            Some(FORMAT) => {}
            Some(other) => return Err(refusal("format", FORMAT, other)),
            None => return Err(refusal("format", FORMAT, "nothing: this is another kind of file")),
        }
        match head.version {
            Some(version) if version == u64::from(VERSION) => {}
            Some(other) => {
                let expected = format!("version {VERSION}; identify the logs again or update the program");
                return Err(refusal("version", &expected, other.to_string()));
            }
            None => return Err(refusal("version", "a number", "nothing")),
        }
        let written: Written =
            serde_json::from_str(text).map_err(|e| refusal("file", "a whole model file", e.to_string()))?;
        let found = checksum(written.model.get());
        if found != written.checksum {
            let expected = format!("{} as when it was written", written.checksum);
            return Err(refusal("checksum", &expected, format!("{found}: the file was damaged or edited")));
        }
        let model: Self = serde_json::from_str(written.model.get())
            .map_err(|e| refusal("model", "the fields of a model", e.to_string()))?;
        model.validate()?;
        Ok(model)
    }
}

fn refusal(name: &str, expected: &str, got: impl Into<String>) -> ModelFileError {
    ModelFileError { name: name.to_string(), expected: expected.to_string(), got: got.into() }
}

fn checksum(text: &str) -> String {
    format!("{:08x}", crc32fast::hash(text.as_bytes()))
}
