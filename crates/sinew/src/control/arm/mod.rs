//! The controller of an arm: measurements of its sensors in, commands of its drives out, once per
//! millisecond.

mod acceleration_law;
mod actuation;
mod allowed_feedback;
mod anchor_motion;
mod cable_states;
mod controller;
mod correction_history;
mod end_point_integral;
mod fault_detector;
mod gains;
mod isolation;
mod iterative_learning;
mod joint_limits;
mod joint_monitor;
mod joint_observer;
mod joint_stiffness;
mod locked_winches;
mod margins;
mod open_loop;
mod pace;
mod period_cost;
mod resting_tensions;
mod sensor_monitor;
mod signals;
mod silence;
mod status;
mod synthesis;
mod tension_following;
mod unmeasured_joints;
mod winch;

pub use actuation::ActuationMode;
pub use cable_states::CableStateSource;
pub use controller::ArmController;
pub(in crate::control) use controller::Observed;
pub use gains::{ArmGains, EndPointGains, JointGains, MuscleGains};
pub use joint_limits::{ACCURACY_CHANGES, JointFigures, JointLimit, LimitedBy, joint_limits};
pub use locked_winches::{LeastStable, MAX_UNSTABLE_RATE, UnheldPose, least_stable_pose, unheld_poses};
pub use margins::DampingMargins;
pub use period_cost::{PeriodCost, PeriodLimit, SlowestPeriod, max_unstable_rate};
pub use resting_tensions::resting_tensions;
pub use signals::{ArmCommand, ArmMeasurement, PreviewedReference};
pub use status::{ArmStatus, Fault, Symptom};
pub use synthesis::{RULE_SOURCES, characterize, synthesize, tension_limits};
