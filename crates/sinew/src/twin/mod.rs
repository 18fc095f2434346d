//! The plant: what a controller is tried on, and may never look into.
//!
//! It builds on the same laws as the controller's models but never shares their numbers: more cells, shorter
//! steps, and effects that no model of the controller has.

pub mod arm;
pub mod bench;
pub mod cable;
