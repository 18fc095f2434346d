//! Simulated servos: their control tables, chains of them, and the machine behind.

mod chain;
mod lines;
mod machine;
#[cfg(target_os = "linux")]
mod serve;
mod servo;

pub use chain::SimulatedChain;
pub use lines::SimulatedLines;
pub use machine::SimulatedMachine;
#[cfg(target_os = "linux")]
pub use serve::serve;
pub use servo::{ENCODER, OVERHEATING, OVERLOAD, ServoFault, ServoGoal, SimulatedServo};
