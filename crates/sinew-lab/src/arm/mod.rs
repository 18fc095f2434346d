//! Experiments on the arm: planning, calibration of its cables, tracking, and the numbers of a run.

mod by_current;
mod calibrate;
mod controller;
mod designed;
mod feasibility;
mod heat;
mod largest_errors;
mod outcome;
mod plan;
mod report;
mod stop_reason;
#[cfg(test)]
mod testing;
mod trace;
mod tracking;
mod verification;
mod written_fault;

pub use by_current::with_gears;
pub use calibrate::{
    CalibratedMuscle, CalibrationProgramme, CalibrationStroke, calibrate_arm, calibrate_networks,
};
pub use designed::{IdentifiedMachine, designed_controller};
pub use feasibility::{InfeasibleMotion, first_infeasibility, infeasible_motion};
pub use heat::{DriveHeat, drive_heat};
pub use largest_errors::{JointShare, LargestError};
pub use outcome::{MAX_END_POINT_ERROR_M, MAX_JOINT_ERROR_FRACTION, TrackOutcome, max_end_point_error};
pub use plan::{CLOSED_PATH_S, DesiredMotion, plan, plan_tour};
pub use report::{
    ErrorRange, ErrorSpread, Hold, MuscleSpread, TrackHealth, TrackIncident, TrackJoint, TrackMode,
    TrackingNumbers,
};
pub use stop_reason::{fault_name, stop_reason};
pub use trace::{Trace, TraceRow};
pub use tracking::{
    CalibratedArm, INITIAL_REST_S, PreparedRun, TrackingResult, TrackingTask, calibration_programmes,
    track_arm,
};
pub use verification::{Verified, VerifiedMotion, VerifiedTour, verify, verify_poses, verify_tour};
pub use written_fault::{FaultSyntaxError, LateFault, UnknownPart, WrittenFault};
