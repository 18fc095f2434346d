//! The body and its muscles: against other programs, against laws, and against nonsense.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod coupled;
mod displaced;
mod golden;
mod joints;
mod laws;
mod muscles;
mod refused;
mod robots;
