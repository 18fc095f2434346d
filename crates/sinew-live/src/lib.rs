//! A simulated machine on a page: its state to browsers sixty times a second, their commands through its supervisor.
//!
//! ```text
//! Simulation   plant, supervisor and motion, one control cycle a step
//! Stage        one or two simulations: time, pause, commands, what is drawn of them
//! Server       HTTP and WebSocket: the page's files, /scene, /stream; a thread of its own steps the stage
//! ```
//!
//! The stage's thread puts its newest state into one place, from which every viewer takes it: a slow viewer misses states and
//! delays nobody. All data is simulated and labelled so.

mod access;
mod choices;
mod command;
mod drawing;
mod error;
mod layout;
mod motion;
mod scene;
mod server;
mod simulation;
mod stage;

pub use choices::Choices;
pub use command::Command;
pub use error::LiveError;
pub use server::{Server, ServerSettings};
pub use simulation::{Simulation, SimulationParts};
pub use stage::{Conditions, SimulationSource, Stage};
