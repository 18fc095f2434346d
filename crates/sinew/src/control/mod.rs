//! Commands of the drives: distribution of tensions for a torque, compensation of friction and stretch,
//! control of an arm; what motions demand of the drives.
//!
//! The controller has measurements, references and identified models; it does not import the plant.

pub mod arm;
pub mod capability;
pub mod compensation;
pub mod demand;
pub mod inverse;
#[cfg(feature = "description")]
pub mod scaling;
pub mod stretch;
pub mod supervisor;
pub mod tension;
pub mod working_tension;

#[cfg(test)]
mod tests;
