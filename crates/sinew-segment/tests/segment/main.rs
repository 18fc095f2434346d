//! Tests of the simulated devices by their public items.
//!
//! One program, so that what the tests share is compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod commands;
mod controller;
mod descriptions;
mod drive;
mod ethercrab;
mod ethercrab_clocks;
mod faults;
mod fuzz;
mod fuzzing;
mod interface;
mod mailbox;
mod master;
mod no_allocation;
mod states;
mod wire;
