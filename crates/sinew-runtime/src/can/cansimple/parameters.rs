//! Parameters of an axis by their numbers, which `flat_endpoints.json` of its firmware names.

use serde_json::Value;

/// The numbers of a firmware's parameters.
#[derive(Debug)]
pub(super) struct Endpoints {
    path: String,
    /// As its file says it.
    pub(super) firmware: String,
    endpoints: Value,
}

/// A parameter with the octets of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parameter {
    pub(super) number: u16,
    octets: [u8; 4],
    length: usize,
}

impl Endpoints {
    /// Reads a file as ODrive offers it for every firmware.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(super) fn read(path: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
        let value: Value = serde_json::from_str(&text).map_err(|error| format!("{path}: {error}"))?;
        let (Some(firmware), Some(endpoints)) =
            (value["fw_version"].as_str(), value.get("endpoints").filter(|endpoints| endpoints.is_object()))
        else {
            return Err(format!("{path}: expected fw_version and endpoints, as in flat_endpoints.json"));
        };
        // What stands behind a hyphen tells builds of one version apart.
        let firmware = firmware.split('-').next().unwrap_or_default().to_owned();
        Ok(Self { path: path.to_owned(), firmware, endpoints: endpoints.clone() })
    }

    /// A parameter of a name with a value.
    ///
    /// # Errors
    /// There is none, or one of another type.
    pub(super) fn parameter(&self, name: &str, value: f64) -> Result<Parameter, String> {
        let of = &self.endpoints[name];
        let number = of["id"].as_u64().and_then(|number| u16::try_from(number).ok());
        let (octets, length) = match of["type"].as_str() {
            Some("bool" | "uint8") => (u32::from(value as u8).to_le_bytes(), 1),
            Some("uint32") => ((value as u32).to_le_bytes(), 4),
            Some("float") => ((value as f32).to_le_bytes(), 4),
            _ => return Err(format!("{}: `{name}` is missing or of another type", self.path)),
        };
        let number = number.ok_or_else(|| format!("{}: `{name}` has no id", self.path))?;
        Ok(Parameter { number, octets, length })
    }
}

impl Parameter {
    /// The message that reads it, or writes its value.
    pub(super) fn request(&self, write: bool) -> ([u8; 8], usize) {
        let [low, high] = self.number.to_le_bytes();
        let [a, b, c, d] = self.octets;
        ([u8::from(write), low, high, 0, a, b, c, d], if write { 4 + self.length } else { 4 })
    }

    /// Whether an answer is one to it, and has its value.
    pub(super) fn is_in(&self, answer: &[u8; 8]) -> Option<bool> {
        let [_, low, high, _, value @ ..] = answer;
        let given = value.get(..self.length)?;
        (u16::from_le_bytes([*low, *high]) == self.number).then(|| self.octets.starts_with(given))
    }
}
