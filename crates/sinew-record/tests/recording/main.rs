//! Recordings of simulated machines: whole, killed, on a full disk, damaged, replayed.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "the program to be killed tells how far it is")]

mod common;
mod damaged;
mod disk;
mod full_ring;
mod killed;
mod no_allocation;
mod old_format;
mod replayed;
mod whole;
