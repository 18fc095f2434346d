//! The control cycle, its deadlines, and how well they are kept.

mod clock;
mod one;
mod realtime;
mod run;
mod timing;

pub use clock::{Clock, MonotonicClock, VirtualClock};
pub use one::{Cycle, CycleRecord, CycleTimes};
pub use realtime::{RealTime, Shortcoming};
pub use run::run;
pub use timing::{Timing, TimingRow};
