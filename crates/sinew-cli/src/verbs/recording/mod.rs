//! Recordings of `sinew run`: what is written beside the cycles, and how it is read again.

mod read;
mod setup;
mod start;

pub(crate) use read::{is_recording, read_bytes, recording};
pub(crate) use setup::{LinkSetup, RunSetup};
pub(crate) use start::{Ended, Recording, Request};
