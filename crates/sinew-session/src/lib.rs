//! One supervised machine in time: whatever moves it, and whatever it is to do.
//!
//! ```text
//! Session<P, M>::step { Plant::read -> Motion::sample -> Supervisor::step -> Plant::write } -> CycleRecord
//! ```
//!
//! | part | what there is |
//! |---|---|
//! | [`Plant`] | [`TwinPlant`] here; drives on EtherCAT and the readings of a recording elsewhere |
//! | [`Motion`] | [`Scheduled`] here; a client over a link, and what a page asks for, elsewhere |
//! | [`Clock`] | [`VirtualClock`] here; the system's elsewhere |
//!
//! Who wants to know what happens, be it a recorder, a page or an evaluation, looks at the [`CycleRecord`] of
//! every cycle. A cycle allocates nothing, takes no lock and makes no system call but those of its plant, its
//! motion and its clock.

mod clock;
mod exchange;
mod motion;
mod plant;
mod record;
mod session;
pub mod signals;
mod twin;

pub use clock::{Clock, VirtualClock};
pub use exchange::{BusFault, BusStatistics, ClockReport, Exchange, Feedback};
pub use motion::{CycleTime, Desired, Motion, References, Scheduled};
pub use plant::Plant;
pub use record::{CycleRecord, CycleTimes};
pub use session::Session;
pub use twin::TwinPlant;
