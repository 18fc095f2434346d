//! The controller of an arm: what its sensors say in, what its drives are to do out, every millisecond.

mod cables;
mod channel;
mod controller;
mod fault_detector;
mod gains;
mod iterative_learning;
mod joints;
mod mechanics;
mod residual;
mod winch;

pub use cables::CableStateSource;
pub use controller::{
    ActuationMode, ArmCommand, ArmController, ArmMeasurement, GroundTruth, PreviewedReference,
};
pub use fault_detector::{ArmStatus, Fault};
pub use gains::ArmGains;
pub use residual::{ResidualInputs, ResidualNetwork};
