//! A run as a node of ROS 2: its state as topics, and where that is asked for trajectories, set-points and
//! modes from other nodes. No ROS is needed to build or to run it.
//!
//! ```text
//! control cycle --Tap, wait-free ring--> Node: a thread --sinew_record::ros2::Messages--> DDS
//! control cycle <--Port, wait-free ring-- Commands <--CDR-- DDS
//! ```
//!
//! | room | purpose |
//! |---|---|
//! | [`Tap`] | the control cycle's end: every so many cycles a frame of all signals |
//! | [`Commands`] | what others ask for, checked, as the commands of a link |
//! | [`Trajectory`] | `trajectory_msgs/JointTrajectory` |
//! | [`Node`] | the thread, and its topics |
//!
//! Messages are those of a bag: see [`sinew_record::ros2`]. DDS, by RustDDS, is built with the feature `dds`
//! alone; without it [`Node::start`] says so.

mod commands;
#[cfg(feature = "dds")]
mod dds;
#[cfg(not(feature = "dds"))]
#[path = "no_dds.rs"]
mod dds;
mod error;
mod node;
mod outgoing;
mod refusal;
mod setpoint;
mod tap;
mod topics;
mod trajectory;
mod trigger;

/// Whether DDS is built in.
pub const IS_BUILT: bool = cfg!(feature = "dds");

pub use commands::{Commands, Sender};
pub use error::Error;
pub use node::{Counts, Node, NodeSettings};
pub use refusal::Refusal;
pub use setpoint::setpoint;
pub use tap::Tap;
pub use topics::{MODES, TOPICS, TopicRow};
pub use trajectory::Trajectory;
pub use trigger::{reply, request_header};
