//! A machine that is commanded from elsewhere: the control cycle's side of `sinew-link`.
//!
//! ```text
//! sinew_link::host::Port --commands--> LinkedMotion { Playout -> SetpointFollower } --reference, request, age--> Session
//!                        <--states---                                              <--SupervisorCommand----
//! ```
//!
//! Nothing here waits but [`LinkedMotion::wait`], which only a cycle on virtual time calls.

mod domain;
mod goals;
mod motion;
mod observed;
mod run_motion;
mod source;
mod tape;

pub use domain::domain;
pub use goals::{GOAL_ROWS, GoalRow, SessionEvent, Then, goal_after, goals_markdown};
pub use motion::{LinkCounts, LinkedMotion};
pub use run_motion::RunMotion;
pub use tape::{CycleInput, Taken, Tape, TapeReader};
