//! Commands to and state of a control cycle over UDP.
//!
//! ```text
//! Client --Hello-->  Host            Host: sockets and authentication in a thread of its own
//! Client <-Welcome-- Host             |  Port::next_input     wait-free queue to the control cycle
//! Client --Command-> Host             |  Port::publish        wait-free queue from the control cycle
//! Client <--State--- Host            Playout: time-stamped set-points to a continuous reference
//! ```
//!
//! | room | purpose |
//! |---|---|
//! | [`wire`] | packets: one table of fields, from which encoder, decoder and documentation follow |
//! | [`host`] | the robot's end: sessions, checks and their counters, server thread, the cycle's port |
//! | [`client`] | the other end |
//! | [`Playout`] | interpolation of set-points over jitter |
//! | [`Key`] | the pre-shared key and its file |
//!
//! The crate knows neither robots nor controllers: numbers have the order of the machine that the host
//! serves.

pub mod client;
mod codes;
mod error;
pub mod host;
mod key;
mod peer;
mod playout;
mod rejection;
mod replay;
mod setpoints;
mod snapshot;
pub mod wire;

pub use codes::{Mode, RefusedBecause, Request, Role, SetpointKind};
pub use error::{Error, KeyFileError};
pub use key::Key;
pub use peer::{Peer, RoundTrip};
pub use playout::{Playing, Playout, Pushed};
pub use rejection::{Counters, Rejection};
pub use replay::{Freshness, ReplayWindow};
pub use setpoints::{Command, Setpoints};
pub use snapshot::{JointState, MuscleState, Snapshot, StateCounts};
