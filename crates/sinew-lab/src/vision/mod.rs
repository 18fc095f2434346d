//! A machine that calibrates its geometry with a camera: poses, the motion through them, the flight on
//! the twin,
//! the estimate judged on poses that it has not seen, and the machine as its controller then knows it.

mod cables;
mod calibration;
mod flight;
mod judge;
mod poses;

pub use cables::{CableJudgement, judge_cables};
pub use calibration::{
    CalibratedBody, CalibratedJoint, CalibratedParameter, CalibratedSite, CalibratedWrap, Calibration,
    ErrorRange, HeldOut, HeldOutCables, Missed, Reported,
};
pub use flight::{Flight, fly};
pub use judge::{Judgement, judge};
pub use poses::{CalibrationPoses, choose_poses, motion_through};
