//! Fits of models to sequences: the clamp cell, the axis, ensembles of networks, one plain network, linear
//! regression, the classical laws.
//!
//! All but the regression are problems given to one search, `levenberg_marquardt`, with a prior of `prior`:
//!
//! | problem                | file               | damping                   | prior                       |
//! |------------------------|--------------------|---------------------------|-----------------------------|
//! | clamp cell             | `cell.rs`          | diagonal, constant factor | ridge                       |
//! | network of an ensemble | `network.rs`       | identity, gain ratio      | groups of weights, evidence |
//! | plain network          | `perceptron/`      | identity, constant factor | none                        |
//! | classical law, cable, axis | `least_squares.rs` | diagonal, growing factor | none                    |

pub(crate) mod axis;
pub(crate) mod cell;
pub mod classical;
pub(crate) mod ensemble;
pub(crate) mod least_squares;
mod levenberg_marquardt;
pub(crate) mod linear;
pub(crate) mod linear_algebra;
mod linearisation;
mod network;
pub mod perceptron;
mod prior;
pub(crate) mod recipe;
pub(crate) mod run;
mod simd;
mod standardisation;
pub(crate) mod statistics;
mod tiles;
