//! The control cycle of a cable-driven robot: read, estimate, control, write, once a period.
//!
//! ```text
//! Clock --deadline--> Session { Plant::read -> Motion::sample -> Supervisor::step -> Plant::write }
//! ```
//!
//! | room | purpose |
//! |---|---|
//! | [`BUSES`] | the buses that a real machine can be on: a room and a line each |
//! | [`ethercat`] | a machine on EtherCAT: link, master, drives after CiA 402; what identifies its devices |
//! | [`cia402`] | drives after CiA 402, on EtherCAT and CAN alike |
//! | [`servos`] | a machine whose drives are serial servos: lines, protocol, registers; simulated servos |
//! | [`can`] | a machine whose drives are nodes on CAN: links, protocols; simulated nodes |
//! | [`link`] | requests and references from a client elsewhere |
//! | [`cycle`] | a session in real time: its deadlines, and how well they are kept |
//!
//! One thread runs the cycle. It allocates nothing, takes no lock and makes no system call but those of its
//! bus and the one that waits for the next deadline. On virtual time it runs as fast as it can, with the same
//! results bit for bit.

mod bus;
pub mod can;
pub mod cia402;
pub mod cycle;
mod devices;
mod error;
pub mod ethercat;
pub mod link;
mod rest;
pub mod servos;
#[cfg(target_os = "linux")]
mod tty;
mod virtual_time;
mod whole;

pub use bus::{AnyDevices, Bus, BusError, DeviceReader, Devices, Tables, Wire};
pub use devices::{BUSES, DeviceTables};
pub use error::Error;
#[cfg(target_os = "linux")]
pub use tty::{PseudoTerminal, Ttys};
