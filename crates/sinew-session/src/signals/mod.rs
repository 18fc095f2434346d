//! The signals of a machine: one table, and a frame of numbers laid out by it.
//!
//! Whoever shows, keeps or sends signals goes through the table: recordings, tables, page, reports, link,
//! Python. A signal that is added to it is in all of them.

mod codes;
mod frame;
mod table;

pub use codes::{bus_fault_of, command_code, fault_of, status_of};
pub use frame::{Frame, FrameLayout};
pub use table::{Axis, Kind, Resolution, Row, Seen, Signal};
