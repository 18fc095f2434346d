//! The control cycle of a cable-driven robot: read, estimate, control, write, once a millisecond.
//!
//! ```text
//! Clock --deadline--> Cycle { Bus::read -> Supervisor::step -> Bus::write }
//! ```
//!
//! | room | purpose |
//! |---|---|
//! | [`bus`] | what a cycle exchanges with drives and sensors, and the bus of a simulated machine |
//! | [`ethercat`] | a machine on EtherCAT: link, master, drives after CiA 402 |
//! | [`link`] | requests and references from a client elsewhere |
//! | [`cycle`] | one cycle, its deadlines, and how well they are kept |
//!
//! One thread runs the cycle. It allocates nothing, takes no lock and makes no system call but those of its bus and the
//! one that waits for the next deadline. On virtual time it runs as fast as it can, with the same results to the bit.

pub mod bus;
pub mod cycle;
mod error;
pub mod ethercat;
pub mod link;

pub use error::Error;
