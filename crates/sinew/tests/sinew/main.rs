//! Tests of the library by its public items.
//!
//! One program, so that what the tests share is compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod approach;
mod arm;
mod arm_twins;
mod body;
mod cable;
mod cable_plant;
mod capability;
mod common;
mod compensator;
mod description;
mod drive;
mod energy;
mod gravity_compensation;
mod inverse_kinematics;
mod joint_motions;
mod machine;
mod no_allocation;
mod online_references;
mod predictor;
mod sizing;
mod springs;
mod supervisor;
mod tension;
mod trajectory;
mod underactuated;
