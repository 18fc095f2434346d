//! A machine whose drives are nodes on CAN: CANopen (CiA 301) with CiA 402, CANSimple (ODrive), moteus,
//! or motors in MIT mode.
//!
//! ```text
//! Link (slcan, fdcanusb, SocketCAN, simulated bus) <-> CanBus: find, compare, configure, read back -> cycle
//! ```
//!
//! A cycle sends every node its command and what asks for its readings: SYNC to all, remote frames to each,
//! or the command itself. The answers are collected when the next cycle begins, so that the bus has the whole
//! period. Readings are as old as they are then.

mod adapter;
mod bus;
mod canopen;
mod cansimple;
mod device;
mod error;
pub mod fdcanusb;
mod file;
#[cfg(target_os = "linux")]
mod guard;
mod link;
mod mit;
mod moteus;
mod scan;
#[cfg(target_os = "linux")]
mod serve;
mod sign;
mod simulated;
mod simulated_link;
pub mod slcan;
mod slot;
#[cfg(target_os = "linux")]
mod socketcan;
mod talk;
#[cfg(target_os = "linux")]
mod watchdog;
#[cfg(target_os = "linux")]
mod wire;
mod words;

#[cfg(target_os = "linux")]
pub use adapter::Adapter;
pub use adapter::Dialect;
pub use bus::CanBus;
pub use canopen::{SdoClient, SdoError};
pub use device::{CanDevice, Protocol};
pub use error::CanError;
pub use file::DeviceTables;
pub use link::Link;
pub use mit::MitMotor;
pub use scan::{FoundNode, scan, scan_fd, scan_mit};
#[cfg(target_os = "linux")]
pub use serve::{HostedAdapter, serve};
pub use sign::Sign;
pub use simulated::SimulatedMachine;
pub use simulated_link::SimulatedLink;
pub use sinew_segment::{CanFault, CanFrame as Frame, CanNode, MitFamily};
#[cfg(target_os = "linux")]
pub use socketcan::SocketCan;
#[cfg(target_os = "linux")]
pub use watchdog::watch;
#[cfg(target_os = "linux")]
pub use wire::connect;
pub use words::words;

#[cfg(not(target_os = "linux"))]
use crate::bus as wire;
use crate::bus::Bus;

/// Nodes behind a serial adapter.
pub const BUS: Bus = Bus {
    name: "can",
    about: "drives on CAN (CANopen, ODrive, moteus, MIT mode), behind the serial adapter or CAN interface of the machine file or of --interface",
    needs_interface: false,
    reads_ahead: true,
    open: wire::open,
    words,
    tables: Some(file::TABLES),
};
