//! The arm as a plant: a body, and for each muscle a drive, a cable in its sheath and a load cell.
//!
//! ```text
//! command -> drive --p_m--> cable, wrap phi(q) --T_out--> tau = R(q)^T T_out -> body -> q --l(q)--> cable
//! ```
//!
//! An [`ArmSpecimen`] holds the parameters, as designed or sampled from a seed; an [`ArmTwin`] simulates it,
//! [`ArmTwins`] several of one machine at once; a list of [`InjectedFault`]s gives the failures and their
//! times.

mod body;
mod deviation;
mod fault;
mod sensors;
mod specimen;
mod state;
mod together;

pub use fault::{ExchangeFailure, Failure, InjectedFault, Sensor, SensorFailure, Worn};
pub use sensors::ArmReading;
pub use specimen::ArmSpecimen;
pub use state::{ArmTruth, ArmTwin};
pub use together::{ArmTwins, Together};
