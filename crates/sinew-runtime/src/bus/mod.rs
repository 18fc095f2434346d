//! What a control cycle exchanges with drives and sensors.

mod exchange;
mod twin;

pub use exchange::{Bus, BusFault, BusStatistics, ClockReport, Exchange, Feedback};
pub use twin::{SimulatedBus, TwinBus};
