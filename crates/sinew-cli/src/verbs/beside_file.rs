//! What a scan has found beside the devices of a machine file.

use std::fmt::Write as _;

/// A device of a machine file.
pub(crate) struct Expected {
    pub(crate) id: u8,
    pub(crate) name: String,
    /// What answers in its place and is not it, by index of what was found: what the file says instead.
    pub(crate) differs: Box<dyn Fn(usize) -> Option<String>>,
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
        let mut name = |(k, id): (usize, &u8)| match expected.iter().find(|device| device.id == *id) {
            None => "none".to_owned(),
            Some(Expected { name, differs, .. }) => match differs(k) {
                None => name.clone(),
                Some(other) => {
                    fits = false;
                    format!("{name}, {other}")
                }
            },
        };
        let names = found.iter().enumerate().map(&mut name).collect();
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
        let device = |id: u8, other: Option<usize>| Expected {
            id,
            name: format!("drive_{id}"),
            differs: Box::new(move |k| (other == Some(k)).then(|| "there another".to_owned())),
        };
        let all = Beside::new(&[device(1, None), device(2, None)], &[2, 1]);
        assert!(all.fits && all.text().is_empty() && all.names == ["drive_2", "drive_1"]);
        let one = Beside::new(&[device(1, None), device(2, None)], &[1, 7]);
        assert!(!one.fits && one.names == ["drive_1", "none"]);
        assert_eq!(one.text(), "drive_2 of the machine file, id 2, does not answer\n");
        let other = Beside::new(&[device(3, Some(0))], &[3]);
        assert!(!other.fits && other.names == ["drive_3, there another"]);
    }
}
