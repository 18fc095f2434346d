//! The live page and Foxglove's protocol over loopback.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

#[path = "../../../sinew-record/tests/recording/common.rs"]
#[allow(dead_code, reason = "the machines and recordings are those of another crate's tests")]
mod common;
mod doors;
#[cfg(feature = "foxglove")]
mod foxglove;
mod page;
mod recorded;
mod tap;
