//! Environments and batches of twins of every machine of this repository.

#![allow(clippy::unwrap_used, reason = "a test that cannot start may panic")]
#![allow(clippy::float_cmp, reason = "equality bit for bit is what is tested")]

mod environments;
mod twins;
