//! Messages of other nodes: read as another program writes them, refused by name, executed by a machine on
//! virtual time; and the control cycle that gives its state to a node. No DDS takes part.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(dead_code, reason = "the machines are those of another crate's tests")]

#[path = "../../../sinew-runtime/tests/runtime/common.rs"]
mod common;
mod executed;
mod messages;
