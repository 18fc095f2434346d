use super::device::DeviceIdentity;
use crate::cia402::{DriveState, NotMapped};

/// Why a machine on EtherCAT does not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EthercatError {
    /// The memory of the frames belongs to another master.
    #[error("the memory of the frames is used by another master")]
    StorageInUse,
    /// Frames do not come back.
    #[error("{during}: {source}")]
    Link {
        /// What was being done.
        during: &'static str,
        /// Of the operating system.
        source: std::io::Error,
    },
    /// The master's protocol failed.
    #[error("{during}: {reason}")]
    Protocol {
        /// What was being done.
        during: String,
        /// In words.
        reason: String,
    },
    /// Nothing is on the wire.
    #[error("no EtherCAT device answers: no frame came back; check cable, power and interface")]
    NoAnswer,
    /// Frames come back, but no device has taken part in them.
    #[error("no EtherCAT device answers: expected {expected}; check cable, power and interface")]
    NoDevices {
        /// Devices of the machine file.
        expected: usize,
    },
    /// The devices are not those of the machine file.
    #[error("the devices on the wire are not those of the machine file: {}", listed(.0))]
    Mismatch(Vec<Mismatch>),
    /// An object that the cycle needs is not in the process data of its device.
    #[error(transparent)]
    NotMapped(#[from] NotMapped),
    /// The process data is longer than the memory for it.
    #[error("process data of {octets} octets: expected at most {most}")]
    TooLong {
        /// Of all devices.
        octets: usize,
        /// The largest possible.
        most: usize,
    },
    /// A device does not become operational.
    #[error("{device} stays in {state}: {reason}")]
    NotOperational {
        /// Name of the device.
        device: String,
        /// Its state.
        state: &'static str,
        /// Its AL status code in words.
        reason: String,
    },
    /// A drive cannot be enabled.
    #[error("{device} is not enabled: {state:?}, error code {code:#06x}")]
    NotEnabled {
        /// Name of the device.
        device: String,
        /// State of the drive.
        state: DriveState,
        /// Its error code, object 0x603F; 0 where it is not in the process data.
        code: u16,
    },
}

/// A place on the wire where the machine file expects something else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// From 0.
    pub position: usize,
    /// Name and identity of the expected device; none where there should be none.
    pub expected: Option<(String, DeviceIdentity)>,
    /// Name and vendor ID, product code and revision number of the device found; none where there is none.
    pub found: Option<(String, [u32; 3])>,
}

impl std::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at position {}: expected ", self.position)?;
        match &self.expected {
            Some((name, identity)) => write!(
                f,
                "`{name}` (vendor {:#x}, product {:#x}, revision {:#x})",
                identity.vendor, identity.product, identity.revision
            )?,
            None => write!(f, "no device")?,
        }
        match &self.found {
            Some((name, [vendor, product, revision])) => {
                write!(
                    f,
                    ", found `{name}` (vendor {vendor:#x}, product {product:#x}, revision {revision:#x})"
                )
            }
            None => write!(f, ", found none"),
        }
    }
}

/// The first mismatches in words.
fn listed(mismatches: &[Mismatch]) -> String {
    const SHOWN: usize = 3;
    let first: Vec<String> = mismatches.iter().take(SHOWN).map(ToString::to_string).collect();
    let more = mismatches.len().saturating_sub(SHOWN);
    let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
    first.join("; ") + &rest
}
