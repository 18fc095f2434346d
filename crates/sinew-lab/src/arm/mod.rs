//! Experiments on the arm: planning, calibration of its cables, tracking, and the numbers of a run.

mod calibrate;
mod controller;
mod plan;
mod report;
mod residual_network;
mod tracking;

pub use calibrate::{CALIBRATION_STROKES, CalibrationStroke, calibrate_arm, calibrate_networks};
pub use plan::{EndPointMotion, first_infeasibility, initial_pose, plan};
pub use report::{
    ErrorSpread, Hold, MAX_END_POINT_ERROR_M, MuscleSpread, Trace, TraceRow, TrackIncident, TrackOutcome,
    TrackingNumbers,
};
pub use residual_network::{FarTensionError, ResidualFit, calibrate_residuals};
pub use tracking::{CalibratedArm, INITIAL_REST_S, TrackingResult, TrackingTask, track_arm};
