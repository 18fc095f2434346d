//! What a scan has found beside the devices of a machine file.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::General;
use crate::error::Error;
use std::fmt::Write as _;

/// A device of a machine file.
pub(crate) struct Expected {
    pub(crate) id: u8,
    pub(crate) name: String,
    /// What the file says instead, where what answers is not it.
    pub(crate) differs: Option<String>,
}

/// A scan with its machine file, if there is one: nothing found, a device that does not answer and one that
/// differs end with exit code 3.
pub(crate) fn answer(
    found_any: bool,
    mut document: serde_json::Value,
    text: impl FnOnce(Option<&Beside>) -> String,
    beside: Option<&Beside>,
    general: &General,
) -> Result<Answer, Error> {
    let outcome = Outcome::new(found_any && beside.is_none_or(|beside| beside.fits));
    let content = if general.json {
        if let Some(beside) = beside {
            document["machine"] = beside.json();
        }
        Content::json(&document)?
    } else {
        Content::Text(text(beside))
    };
    Ok(Answer { outcome, content, written: Vec::new() })
}

/// What was found, each with its place in the machine file.
pub(crate) struct Beside {
    /// Name of its device, with what the file says otherwise; `none`.
    pub(crate) names: Vec<String>,
    /// Devices that do not answer, with their identifiers.
    pub(crate) silent: Vec<(String, u8)>,
    /// Whether all answer, and nothing differs.
    pub(crate) fits: bool,
}

impl Beside {
    /// Compares the identifiers that answered with the devices.
    pub(crate) fn new(expected: &[Expected], found: &[u8]) -> Self {
        let mut fits = true;
        let mut name = |id: &u8| match expected.iter().find(|device| device.id == *id) {
            None => "none".to_owned(),
            Some(Expected { name, differs: None, .. }) => name.clone(),
            Some(Expected { name, differs: Some(other), .. }) => {
                fits = false;
                format!("{name}, {other}")
            }
        };
        let names = found.iter().map(&mut name).collect();
        let silent = expected.iter().filter(|device| !found.contains(&device.id));
        let silent: Vec<_> = silent.map(|device| (device.name.clone(), device.id)).collect();
        Self { names, fits: fits && silent.is_empty(), silent }
    }

    /// A sentence on those that do not answer.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for (name, id) in &self.silent {
            let _ = writeln!(text, "{name} of the machine file, id {id}, does not answer");
        }
        text
    }

    /// For programs.
    pub(crate) fn json(&self) -> serde_json::Value {
        let silent: Vec<_> =
            self.silent.iter().map(|(name, id)| serde_json::json!({ "name": name, "id": id })).collect();
        serde_json::json!({ "devices": self.names, "silent": silent, "matches": self.fits })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_answers_has_its_device_and_what_does_not_is_named() {
        let device = |id: u8, differs: Option<&str>| Expected {
            id,
            name: format!("drive_{id}"),
            differs: differs.map(str::to_owned),
        };
        let all = Beside::new(&[device(1, None), device(2, None)], &[2, 1]);
        assert!(all.fits && all.text().is_empty() && all.names == ["drive_2", "drive_1"]);
        let one = Beside::new(&[device(1, None), device(2, None)], &[1, 7]);
        assert!(!one.fits && one.names == ["drive_1", "none"]);
        assert_eq!(one.text(), "drive_2 of the machine file, id 2, does not answer\n");
        let other = Beside::new(&[device(3, Some("there another"))], &[3]);
        assert!(!other.fits && other.names == ["drive_3, there another"]);
    }
}
