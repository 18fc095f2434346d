//! Exports against the library: the same bits, from every compiler that is there.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bits;
mod compiler;
mod models;
mod samples;
mod units;
