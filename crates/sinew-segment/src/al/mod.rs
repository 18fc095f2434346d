//! The state machine of the application layer: INIT, PRE-OP, SAFE-OP, OP.

mod machine;
mod state;
mod status_code;

pub(crate) use machine::{Machine, Surroundings, Transition};
pub use state::AlState;
pub use status_code::AlStatusCode;
