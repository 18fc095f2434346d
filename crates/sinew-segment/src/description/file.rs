//! A file with descriptions of devices, whichever of the two kinds it is.

use super::esi_node::{EsiFile, child};
use super::{DescriptionError, DeviceDescription, Identity, esi};

/// A file that describes devices: a table in TOML with one, or an ESI file with many, read as they are asked
/// for.
#[derive(Debug, Clone)]
pub struct DescriptionFile {
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    Table(Box<DeviceDescription>),
    Esi { name: String, text: String, identities: Vec<Identity> },
}

impl DescriptionFile {
    /// Reads a file; `name` names it in errors. A file that begins with `<` is an ESI file, in UTF-8 or ISO
    /// 8859-1; every other one is a table in UTF-8.
    ///
    /// # Errors
    ///
    /// Neither of the two, or the first line with a missing, unknown or unusable field. Of an ESI file the
    /// identities alone are read here.
    pub fn read(name: &str, content: &[u8]) -> Result<Self, DescriptionError> {
        let text = match std::str::from_utf8(content) {
            Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
            // Vendors still write ISO 8859-1, whose octets are the first code points.
            Err(_) if is_xml(content) => content.iter().copied().map(char::from).collect(),
            Err(error) => {
                let before = content.get(..error.valid_up_to()).unwrap_or_default();
                return Err(DescriptionError {
                    file: name.to_owned(),
                    line: before.iter().filter(|octet| **octet == b'\n').count() + 1,
                    field: "text".to_owned(),
                    problem: "not UTF-8, expected a device table in TOML or an ESI file".to_owned(),
                });
            }
        };
        let content = if is_xml(text.as_bytes()) {
            let identities = identities(name, &text)?;
            Content::Esi { name: name.to_owned(), text, identities }
        } else {
            Content::Table(Box::new(DeviceDescription::from_toml(name, &text)?))
        };
        Ok(Self { content })
    }

    /// The devices that it describes; of an ESI file without serial numbers.
    #[must_use]
    pub fn identities(&self) -> &[Identity] {
        match &self.content {
            Content::Table(device) => std::slice::from_ref(&device.identity),
            Content::Esi { identities, .. } => identities,
        }
    }

    /// The description of the device with a product code and revision of [`identities`](Self::identities).
    ///
    /// # Errors
    ///
    /// The first element of the device that is missing or out of range; a device that is not in the file.
    pub fn describe(&self, product: u32, revision: u32) -> Result<DeviceDescription, DescriptionError> {
        match &self.content {
            Content::Table(device) => Ok((**device).clone()),
            Content::Esi { name, text, .. } => {
                DeviceDescription::from_esi(name, text, Some(product), Some(revision))
            }
        }
    }
}

impl From<DeviceDescription> for DescriptionFile {
    fn from(device: DeviceDescription) -> Self {
        Self { content: Content::Table(Box::new(device)) }
    }
}

fn is_xml(content: &[u8]) -> bool {
    let content = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content);
    content.trim_ascii_start().starts_with(b"<")
}

fn identities(name: &str, text: &str) -> Result<Vec<Identity>, DescriptionError> {
    let document = esi::parse(name, text)?;
    let file = EsiFile { name };
    let (vendor, devices) = esi::devices(file, &document)?;
    let mut identities = Vec::new();
    for node in devices {
        // Devices without a product code are parts of others.
        let Some(kind) = child(node, "Type").filter(|kind| kind.has_attribute("ProductCode")) else {
            continue;
        };
        let get = |attribute| file.fit(kind, attribute, file.attribute(kind, attribute)?.unwrap_or(0));
        let (product, revision) = (get("ProductCode")?, get("RevisionNo")?);
        identities.push(Identity { vendor, product, revision, serial: 0 });
    }
    if identities.is_empty() {
        return Err(file.error(document.root_element(), "expected at least one <Device> with a ProductCode"));
    }
    Ok(identities)
}
