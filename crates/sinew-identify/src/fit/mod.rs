//! Fits: the clamp cell, the network, the classical laws.

pub mod classical;
pub mod levenberg_marquardt;
