//! Experiments on the twin.
//!
//! One program, so that what the tests share is compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod any_machine;
mod approach;
mod arm;
mod arm_control;
mod arm_faults;
mod bench;
mod by_current;
mod cable_tables;
mod common;
mod edited_files;
mod healthy;
mod locked_winches;
mod reproduce_bench;
mod sensor_faults;
mod sensor_moments;
mod sheath_bend;
mod spread_files;
mod supervisor;
mod underactuated;
mod unknown_cable;
