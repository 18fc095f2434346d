//! Fits: the clamp cell, the network, the classical laws.

pub(crate) mod cell;
mod dense;
pub mod gram;
pub(crate) mod network;
