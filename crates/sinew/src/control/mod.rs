//! Commands of the drives: distribution of tensions for a torque, compensation of friction and stretch,
//! control of an arm.
//!
//! The controller has measurements, references and identified models; it does not import the plant.

pub mod arm;
pub mod compensation;
pub mod stretch;
pub mod tension;
