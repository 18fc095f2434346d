//! The cable in its sheath: against a fine reference, against closed forms, and against the laws of energy.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod accuracy;
mod energy;
mod laws;
mod reference;
