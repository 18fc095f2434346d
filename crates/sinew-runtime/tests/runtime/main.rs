//! Machines under control over simulated buses, in virtual time.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bus_faults;
mod clocks;
mod common;
mod link;
mod segment;
