//! A machine whose drives are serial servos: Dynamixel (protocol 2.0) and Feetech STS.
//!
//! ```text
//! Lines (serial ports, simulated chains) <-> ServoBus: find, compare, configure, read back -> cycle
//! ```
//!
//! A cycle sends all goals and the request for all readings at once; the answers are collected when the next
//! one begins, so that the line has the whole period. Readings are as old as they are then.

mod bring_up;
mod bus;
mod device;
mod error;
mod file;
mod line;
mod model;
pub mod protocol;
mod registers;
mod scan;
mod series;
mod simulated;
mod slot;
#[cfg(target_os = "linux")]
mod wire;
mod words;

pub use bus::ServoBus;
pub use device::{OperatingMode, ServoDevice};
pub use error::ServoError;
pub use file::DeviceTables;
pub use line::Lines;
pub use model::Model;
pub use registers::{BAUD, Registers, eeprom, sts};
pub use scan::{FoundServo, scan};
pub use series::Series;
#[cfg(target_os = "linux")]
pub use simulated::serve;
pub use simulated::{
    ENCODER, OVERHEATING, OVERLOAD, ServoFault, ServoGoal, SimulatedChain, SimulatedLines, SimulatedMachine,
    SimulatedServo,
};
pub use words::words;

#[cfg(not(target_os = "linux"))]
use crate::bus as wire;
use crate::bus::Bus;

/// Servos on serial ports.
pub const BUS: Bus = Bus {
    name: "servos",
    about: "Serial servos: Dynamixel or Feetech, on the ports of the machine file or of --interface",
    needs_interface: false,
    reads_ahead: true,
    open: wire::open,
    words,
    tables: Some(file::TABLES),
};
