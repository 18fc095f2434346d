//! The arm as a plant: a body, and for each muscle a drive, a cable in its sheath and a load cell.
//!
//! ```text
//! command -> drive --p_m--> cable, wrap phi(q) --T_out--> tau = R(q)^T T_out -> body -> q --l(q)--> cable
//! ```
//!
//! An [`ArmSpecimen`] says what is built, as designed or drawn from a seed; an [`ArmTwin`] moves it; a list of
//! [`InjectedFault`]s says what fails and when.

mod body;
mod fault;
mod sensors;
mod specimen;
mod state;

pub use body::STOP_STIFFNESS;
pub use fault::{Failure, InjectedFault, Sensor, SensorFailure};
pub use sensors::ArmReading;
pub use specimen::{ArmSpecimen, Scatter};
pub use state::{ArmTruth, ArmTwin};
