//! Machines under control over simulated buses, in virtual time.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bus_faults;
mod bus_stops;
mod campaign;
mod can;
mod can_common;
mod clocks;
mod common;
mod device_tables;
mod link;
mod link_stops;
mod mit;
mod no_allocation;
mod segment;
mod servos;
#[cfg(target_os = "linux")]
mod servos_foreign;
mod servos_protocol;
#[cfg(target_os = "linux")]
mod veth;
