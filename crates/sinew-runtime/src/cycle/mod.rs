//! A session in real time: its deadlines, and how well they are kept.

mod clock;
mod realtime;
mod run;
mod timing;

use crate::link::RunMotion;
pub use clock::MonotonicClock;
pub use realtime::{RealTime, Shortcoming};
pub use run::run;
pub use sinew_session::{Clock, CycleRecord, CycleTimes, VirtualClock};
pub use timing::{Timing, TimingRow};

/// A session that follows a schedule or a client.
pub type Cycle<'a, P> = sinew_session::Session<P, RunMotion<'a>>;
