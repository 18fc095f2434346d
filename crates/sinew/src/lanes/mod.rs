//! Numbers of several worlds side by side, one in each SIMD lane: laws are written once, over rows.
//!
//! A row of one number is that number, a row of eight is eight worlds. Every operation is that of `f64` in
//! each lane, so that a lane has the bits of a world alone on every instruction set. Loops, not closures, and
//! inlined always: only inlined code is compiled for the instruction set of its caller.

mod abreast;
mod angles;
mod row;
mod space;

pub(crate) use abreast::{Abreast, abreast, abreast_as_it_is};
pub(crate) use row::{Mask, Row};
pub(crate) use space::{Frame, Vector};
