//! Physics and mathematics of robots whose muscles are motors pulling cables through sheaths.
//!
//! No I/O, no clock, no threads, and no allocation once a thing is built. The crate is `no_std` (with
//! `alloc` for construction), so the stepping parts run on a drive's own controller as they run here,
//! to the same bit: mathematics comes from `libm`, not from the platform.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod body;
pub mod control;
pub mod description;
mod dispatch;
pub mod drive;
mod error;
pub mod math;
pub mod metrics;
pub mod muscle;
pub mod predictor;
pub mod random;
pub mod trajectory;
pub mod transmission;
pub mod twin;

pub use error::Error;

// The README's Rust is compiled with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
