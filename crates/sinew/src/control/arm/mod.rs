//! The controller of an arm: what its sensors say in, what its drives are to do out, every millisecond.

mod cables;
mod channel;
mod controller;
mod gains;
mod guard;
mod joints;
mod mechanics;
mod practice;
mod residual;
mod winch;

pub use cables::Knowledge;
pub use controller::{ArmAnswer, ArmController, ArmSample, Goal, Told, Way};
pub use gains::ArmGains;
pub use guard::{ArmStatus, Trouble};
pub use residual::{Ends, Residual};
