//! Fits: the clamp cell, the network, the classical laws.

pub mod gram;
pub mod perceptron;
