//! What a drive is told: tensions for a torque, compensation of friction and stretch.
//!
//! Nothing here may look into the plant: it knows what sensors say and what was identified.

pub mod arm;
pub mod compensation;
pub mod stretch;
pub mod tension;
