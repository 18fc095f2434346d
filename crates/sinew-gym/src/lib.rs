//! Environments for reinforcement learning on simulated machines whose motors pull cables through sheaths.
//!
//! An agent is told what a robot's sensors tell and commands its drives; every episode begins in another
//! pose, with another specimen of the machine. No controller of this project takes part.
//!
//! | module          | content                                                                       |
//! |-----------------|-------------------------------------------------------------------------------|
//! | `settings`      | what is commanded, how often, for how long, in which resolution                |
//! | `randomisation` | which numbers of the machine differ from episode to episode, and by how much   |
//! | `task`          | reach a pose, track a motion, hold a pose against pushes                       |
//! | `design`        | a machine, a task and settings, checked together: what all environments share  |
//! | `observation`   | the layout of observations                                                     |
//! | `episode`       | what is sampled at the beginning of an episode                                   |
//! | `environment`   | one environment: reset, step                                                   |
//! | `batch`         | many of them, with resets of ended episodes                                    |
//! | `twins`         | many simulated machines without a task                                         |
//! | `groups`        | how eight of them step together                                                |
//! | `threads`       | how threads share the groups                                                   |
//!
//! Every environment has its own random numbers: what it does depends on its seed and its actions alone, to
//! the bit, whatever the number of environments and threads. Everything is simulated.

mod batch;
mod design;
mod environment;
mod episode;
mod groups;
mod observation;
mod randomisation;
mod settings;
mod task;
mod threads;
mod twins;

pub use batch::{EnvironmentBatch, Outcomes, ResetMode};
pub use design::EnvironmentDesign;
pub use environment::{Environment, Outcome, Target};
pub use observation::ObservationPart;
pub use randomisation::Randomisation;
pub use settings::{Actuation, Settings};
pub use task::Task;
pub use twins::TwinBatch;
