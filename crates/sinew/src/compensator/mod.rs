//! The inverse of a model: the near-side command for which the far end is what is desired, one sample at a
//! time.
//!
//! ```text
//! F(u): what the predictor says of the next sample with u in the near column, from its present state
//! u = u_0                                            where |F(u_0) - y*| <= tolerance     (nothing to do)
//! u = the first u from u_0 toward y* with F(u) past y*, by halving the reach              (else)
//! reach: u_0 -+ min(rate dt, the largest change that the predictor accepts), within [min, max]
//! ```
//!
//! | symbol | meaning                                                                    | unit  |
//! |--------|----------------------------------------------------------------------------|-------|
//! | u, u_0 | command; the near side at the sample before, as measured                     | near  |
//! | y*     | desired far end                                                              | far   |
//! | F      | forward model: the same code that predicts, on a copy of the state            | far   |
//!
//! Halving has two properties that faster searches lack: whatever the model, the command is monotone in `y*`,
//! because neither the reach nor the points that are tried depend on it until the commands part; and the work
//! is bounded. In the dead band, where `F` does not depend on `u`, the command stays while the far end is
//! as desired, and crosses the band at the largest rate when it is not.
//!
//! The far end of a cable answers a motion of its motor only once that has spread along the sheath. Its motor
//! goes by the stretch of steady sliding, and exactly where that is near.
//!
//! # Departs
//! `yuan2023`, (8) and (17), computes the drive's tension from present values alone. Here the model's memory
//! takes part: the dead band at a reversal is crossed once.
//!
//! # Source
//! `yuan2023`, (8) corrected and (17); bisection. Our own choice of the start and of the reach.

mod cable;
mod command;
mod direction;
mod error;
mod reach;
mod response;
mod search;
mod settings;
mod step;

pub use command::{Command, CommandFlags};
pub use error::CompensatorError;
pub use settings::CompensatorSettings;
pub use step::{CableConstants, Compensator, CompensatorConstants, MAX_EVALUATIONS};
