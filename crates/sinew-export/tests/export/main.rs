//! Exports against the library: the same bits, from every compiler that is there.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "tests say what they skip and how many lines they reach")]

mod analysers;
mod bits;
mod compiler;
mod cortex;
mod inverse;
mod models;
mod onnx;
mod samples;
mod times;
mod units;
