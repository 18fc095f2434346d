//! Machines under control over simulated buses, in virtual time.

mod bus_faults;
mod common;
mod segment;
