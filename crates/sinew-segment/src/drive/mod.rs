//! A drive after CiA 402: state machine, modes, limits. The motor itself is outside.

mod axis;
mod objects;
mod state;

pub use axis::{AxisCommand, Drive, Mode};
pub use state::DriveState;
