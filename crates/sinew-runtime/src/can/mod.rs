//! A machine whose drives are nodes on CAN: CANopen (CiA 301), CiA 402.
//!
//! ```text
//! Link (slcan, simulated bus) <-> CanBus: find, compare, configure, read back -> cycle
//! ```
//!
//! A cycle sends every node its command and then SYNC, on which all take them over and answer; the answers
//! are collected when the next cycle begins, so that the bus has the whole period. Readings are as old as
//! they are then.

mod bring_up;
mod bus;
mod device;
mod error;
mod file;
mod link;
mod scan;
mod sdo;
mod simulated;
mod simulated_link;
pub mod slcan;
#[cfg(target_os = "linux")]
mod wire;
mod words;

pub use bus::CanBus;
pub use device::CanDevice;
pub use error::CanError;
pub use file::DeviceTables;
pub use link::Link;
pub use scan::{FoundNode, scan};
pub use sdo::{SdoClient, SdoError};
pub use simulated::SimulatedMachine;
pub use simulated_link::SimulatedLink;
pub use sinew_segment::{CanFault, CanFrame as Frame, CanNode};
#[cfg(target_os = "linux")]
pub use wire::{Slcan, serve};
pub use words::words;

#[cfg(not(target_os = "linux"))]
use crate::bus as wire;
use crate::bus::Bus;

/// Nodes behind a serial adapter.
pub const BUS: Bus = Bus {
    name: "can",
    about: "CANopen drives, behind a serial adapter (slcan) of the machine file or of --interface",
    needs_interface: false,
    reads_ahead: true,
    open: wire::open,
    words,
    tables: Some(file::TABLES),
};
