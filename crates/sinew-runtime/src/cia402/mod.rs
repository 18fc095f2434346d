//! Drives after CiA 402, on whatever bus they are: state machine, process data, the winch behind.

mod drive;
mod image;
mod simulated;
mod state;

pub use image::{NotMapped, ObjectAddress};
pub use state::DriveState;

pub(crate) use drive::{
    CONTROLWORD, DriveSlot, MODE, POSITION, STATUSWORD, TARGET_VELOCITY, TORQUE, desired_mapping,
    mode_of_operation,
};
pub(crate) use image::{Field, Mapping};
pub(crate) use simulated::{Axis, Measured, WinchFault};
