//! A machine on a page: its state to browsers sixty times a second, their commands back to it.
//!
//! ```text
//! Stage        one or two simulations: time, pause, commands through their supervisors, what is drawn of them
//! Playback     a recording in time, and another one over it
//! Kinematic    a machine that is moved without forces
//! Tap -> Run   a run that goes on elsewhere: its control cycle puts signals into a ring, the page takes the newest
//! Server       HTTP and WebSocket: the page's files, /scene, /history, /stream; a thread of its own owns one of these sources
//! ```
//!
//! With the feature `foxglove` the same thread shows the source in Foxglove as well.
//!
//! That thread puts the newest state into one place, from which every viewer takes it: a slow viewer misses
//! states and delays nobody. What is simulated is labelled so.

mod access;
mod beside;
mod choices;
mod command;
mod connections;
mod drawing;
mod error;
#[cfg(feature = "foxglove")]
mod foxglove_view;
mod frame;
mod kinematic;
mod layout;
mod motion;
mod recording;
mod routes;
mod scene;
mod server;
mod show;
mod signals;
mod simulation;
mod source;
mod stage;
mod tap;
mod viewer;

pub use choices::Choices;
pub use command::{Command, MAX_COMMAND};
pub use error::LiveError;
pub use kinematic::Kinematic;
pub use recording::{Playback, PlaybackParts};
pub use server::{Server, ServerSettings};
pub use simulation::{Simulation, SimulationParts};
pub use source::Source;
pub use stage::{Conditions, SimulationSource, Stage};
pub use tap::{Run, RunParts, Tap, tap};
