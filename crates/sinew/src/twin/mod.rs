//! The plant: the simulated system that controllers are tested on; no controller reads its state or
//! parameters.
//!
//! Plant and controller models use the same laws of cable, muscle and body, with different parameters: the
//! plant is a sampled specimen, discretised more finely, and has effects that no model of the controller has
//! ([`cable`]).

pub mod arm;
pub mod bench;
pub mod cable;
pub mod camera;
