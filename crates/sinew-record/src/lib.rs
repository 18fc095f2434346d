//! Recordings of a control cycle: every cycle of a run in an MCAP file, and what comes back from it.
//!
//! ```text
//! control cycle --> Recorder --ring--> thread --> a message per cycle --> chunks of the file
//! file --> Recording --> blocks of cycles --> tables, reports, the same controller again
//! ```
//!
//! Readings are kept bit for bit, as short numbers; commands rounded, with a check of their bits; references
//! as a check, because they follow from the motion. A file ends at any time with its last whole chunk: half a
//! second is missing at most where its writer was killed.

mod block;
mod channels;
mod error;
mod fields;
mod format1;
mod grid;
mod head;
mod messages;
mod read;
mod recorder;
mod records;
mod replay;
pub mod ros2;
mod sink;
mod view;

pub use block::Block;
pub use channels::File;
pub use error::Error;
pub use grid::Grid;
pub use head::{BLOCK, COMMAND, Circumstances, Coding, ColumnSpec, FORMAT, Head, JointColumn, STRIDE};
pub use read::{BlockPlace, Blocks, Recording};
pub use recorder::{Recorded, Recorder};
pub use replay::{BlockChecks, Replay, ReplayedCycle};
pub use ros2::{Bag, Track, ros2_bag, ros2_tracks};
pub use sinew_session::signals::{Signal, bus_fault_of, command_code, fault_of, status_of};
pub use sink::Storage;
