//! A machine on EtherCAT.
//!
//! ```text
//! Link (raw socket, simulated segment) <-> ethercrab <-> Master --scan, match--> Matched --configure, enable--> EthercatBus
//! ```
//!
//! The states of the bus are types: only an [`EthercatBus`], whose devices matched the machine and are
//! operational, is a [`Plant`](sinew_session::Plant), so that no torque can be written before.
//!
//! Frames are pumped in the calling thread, so that a cycle starts no other thread and allocates nothing.

mod bring_up;
mod clocks;
mod device;
mod emergency;
mod error;
mod file;
mod found;
mod link;
mod master;
mod matched;
mod operational;
mod process_data;
mod pump;
#[cfg(target_os = "linux")]
mod raw_link;
mod recovery;
mod segment_link;
#[cfg(target_os = "linux")]
mod serve;
mod sii;
mod simulated_machine;
mod slots;
mod time;
#[cfg(target_os = "linux")]
mod wire;
mod words;

pub use device::{ChannelObjects, DeviceIdentity, EthercatDevice, RevisionRule};
pub use error::{EthercatError, Mismatch};
pub use file::DeviceTables;
pub use found::{FoundDevice, compare};
pub use link::Link;
pub use master::Master;
pub use matched::{Matched, Refused};
pub use operational::EthercatBus;
pub use pump::FrameStorage;
#[cfg(target_os = "linux")]
pub use raw_link::RawSocketLink;
pub use segment_link::SegmentLink;
#[cfg(target_os = "linux")]
pub use serve::serve;
pub use simulated_machine::SimulatedMachine;
pub use words::words;

#[cfg(not(target_os = "linux"))]
use crate::bus as wire;
use crate::bus::Bus;

/// Devices on a network interface.
pub const BUS: Bus = Bus {
    name: "ethercat",
    about: "Devices on a network interface",
    needs_interface: true,
    reads_ahead: false,
    open: wire::open,
    words,
    tables: Some(file::TABLES),
};
