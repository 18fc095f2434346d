//! A machine on cables as designed: its body, and for every muscle a sheath, a cable and a drive; sensors,
//! task, limits and the tolerances of its manufacture.
//!
//! ```text
//! body (robot)  +  muscles (sheath, cable, drive)  +  encoders  +  task  =  Machine
//! Machine  ->  plant as designed and as built (twin)  ->  calibration
//!          ->  gains and thresholds (control)         ->  controller
//! ```
//!
//! [`Characteristics`] are what gains, thresholds and the integration of the plant follow from.
//!
//! Everything but the body has a default: [`Machine::from_robot`].

mod cables;
mod change;
mod characteristics;
mod clearance;
mod design;
mod device;
mod marker;
mod muscle;
mod period;
mod routing;
mod rules;
mod safety;
mod stability;
mod task;
mod tolerances;

pub use change::DesignChange;
pub use characteristics::{Characteristics, JointCharacteristics, MuscleCharacteristics};
pub use clearance::Clearance;
pub use design::Machine;
pub use device::{Device, DeviceRole, DriveDevice, DriveMode, SensorChannel, Signal};
pub use marker::{BASE_MARKER_SD_M, LINK_MARKER_SD_M, Marker};
pub use muscle::MuscleDesign;
pub(crate) use period::parts_of;
pub use period::{DEFAULT_PERIOD, PERIOD_RANGE, dead_time};
pub use routing::Routing;
pub use rules::ControlRules;
pub use safety::{DriveLimits, SafetyLimits};
pub use stability::{HeldStability, NegativeStiffness};
pub use task::{NamedPath, Task};
pub use tolerances::{Tolerances, Workshop};
