//! Fits: the clamp cell, the network, the classical laws.

pub(crate) mod cell;
pub mod classical;
mod dense;
pub(crate) mod ensemble;
pub mod gram;
pub mod levenberg_marquardt;
pub(crate) mod network;
pub mod perceptron;
pub(crate) mod recipe;
pub(crate) mod run;
pub(crate) mod statistics;
