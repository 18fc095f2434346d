//! Tests of identification by its public items.
//!
//! One program, so that what the tests share is compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bad_logs;
mod broken_logs;
mod cable;
mod classical_coverage;
mod classical_laws;
mod common;
mod exported_logs;
mod identification;
mod likeness;
mod long_broken_logs;
mod long_identification;
mod mat5_logs;
mod moving_masses;
mod optional_formats;
mod perceptron;
mod sequences;
mod specimen;
mod text_logs;
