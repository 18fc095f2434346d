//! Tests of the simulated devices by their public items.
//!
//! One program, so that what the tests share is compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod commands;
mod controller;
mod descriptions;
mod drive;
mod faults;
mod fuzz;
mod fuzzing;
mod interface;
mod mailbox;
mod states;
#[path = "../wire/mod.rs"]
mod wire;
