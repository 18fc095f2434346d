//! The drive of a muscle (MC-AM): motor, reducer, winch, their loops and sensors.
//!
//! ```text
//! command -> tension loop -> velocity loop -> current loop -> motor -> reducer -> winch -> cable
//! ```

mod batch;
#[cfg(feature = "description")]
mod catalogue;
mod current_loop;
mod endurance;
mod exchange;
mod lanes;
mod machine;
mod motor;
mod parameters;
mod quadrant;
mod reducer;
mod sensors;
#[cfg(feature = "description")]
pub mod sizing;
mod speed_control;
mod state;
mod tension_loop;
mod velocity_loop;
mod winch;

pub(crate) use batch::DriveBatch;
#[cfg(feature = "description")]
pub use catalogue::{
    Catalogue, CatalogueCord, CatalogueMotor, CatalogueReducer, CatalogueWinch, Cord, ReducerLosses,
};
pub use current_loop::CurrentLoop;
pub use endurance::MotorTemperatures;
pub use exchange::{DriveCommand, DriveFault, DriveReading, DriveStep};
pub use machine::Drive;
pub use motor::{Motor, MotorState, ROOM};
pub use parameters::DriveParameters;
pub use quadrant::Quadrant;
pub use reducer::{Reducer, Shaft, Turn};
pub use sensors::{Delay, Encoder, JointEncoder, LoadCell};
pub use speed_control::{MeasuredShaft, SpeedControl};
pub use tension_loop::TensionLoop;
pub use velocity_loop::{VelocityLimits, VelocityLoop};
pub use winch::Winch;
