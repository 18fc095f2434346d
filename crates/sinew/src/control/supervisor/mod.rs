//! Operation of a machine: modes, limits, faults with their reactions, cable health.
//!
//! Physics and logic without clock and I/O: time is the length of the control cycles and what an
//! [`ExchangeStatus`] tells. `docs/supervisor.md` is the same for users; its table of transitions is written
//! from [`TRANSITIONS`].

mod current_tension;
mod fault_code;
mod fault_kind;
mod health;
mod heat;
mod held;
mod limits;
mod machine_supervisor;
mod mode;
mod monitor;
mod pretension;
mod safe_stop;
mod signals;
mod threshold;
mod transitions;

pub use fault_code::{Counted, FaultCode, fault_codes_markdown};
pub use fault_kind::FaultKind;
pub use health::{CableHealth, Drift};
pub use limits::{Limits, MuscleLimits};
pub use machine_supervisor::Supervisor;
pub use mode::{Mode, Request};
pub use signals::{ExchangeStatus, MuscleState, NamedFault, SupervisorCommand};
pub use threshold::Threshold;
pub use transitions::{Condition, TRANSITIONS, Transition, transitions_markdown};
