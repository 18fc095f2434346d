//! Files that describe the devices of a simulated bus.

use crate::error::Error;
use sinew_runtime::ethercat::EthercatDevice;
use sinew_segment::DescriptionFile;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

/// Reads all files; each describes a device of the machine.
pub(super) fn read(paths: &[PathBuf], devices: &[EthercatDevice]) -> Result<Vec<DescriptionFile>, Error> {
    let mut files = Vec::new();
    for path in paths {
        let content = content(path).map_err(|source| Error::Unreadable { file: path.clone(), source })?;
        let file = DescriptionFile::read(&path.display().to_string(), &content)?;
        let accepted = file.identities().iter().any(|of| {
            devices.iter().any(|device| device.identity.accepts([of.vendor, of.product, of.revision]))
        });
        if !accepted {
            return Err(Error::ForeignDevices {
                file: path.clone(),
                described: file.identities().len(),
                expected: expected(devices),
            });
        }
        files.push(file);
    }
    Ok(files)
}

/// Vendors put hundreds of devices into one file: no file of them is larger, octets.
const LARGEST: u64 = 1 << 28;

fn content(path: &Path) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    File::open(path)?.take(LARGEST + 1).read_to_end(&mut content)?;
    if content.len() as u64 > LARGEST {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "expected a file of at most 256 MiB"));
    }
    Ok(content)
}

/// The kinds of devices of a machine: vendor:product, revision.
fn expected(devices: &[EthercatDevice]) -> String {
    let mut kinds: Vec<String> = Vec::new();
    for device in devices {
        let of = device.identity;
        let kind = format!("{:#x}:{:#x} revision {:#x}", of.vendor, of.product, of.revision);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    kinds.join(", ")
}
