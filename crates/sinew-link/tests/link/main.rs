//! The link by its promises.
#![allow(clippy::unwrap_used, reason = "a test that fails says where")]

#[path = "../adversary/mod.rs"]
mod adversary;
mod campaign;
mod clients;
mod documentation;
mod golden;
mod network;
mod playout;
mod sessions;
