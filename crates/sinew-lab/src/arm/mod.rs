//! An arm from its calibration to its tracking: what is identified, how it is then controlled, and what came of it.

mod calibrate;
mod journey;
mod report;
mod residual;
mod tracking;
mod variant;

pub use calibrate::{STROKES, Strokes, calibrate_arm, calibrate_networks};
pub use journey::{Route, journey, obstacle};
pub use report::{ErrorSpread, Hold, MuscleSpread, Trace, TraceRow, TrackIncident, TrackingNumbers};
pub use residual::{Left, ResidualFit, calibrate_residuals};
pub use tracking::{BEFORE, Prepared, Tracking, Walk, first_pose, track_arm};
pub use variant::Variant;
