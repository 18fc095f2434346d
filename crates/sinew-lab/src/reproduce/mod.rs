//! The experiments of `yuan2023` on the twin: its tables and figures with simulated numbers.

mod arm;
mod bench;
mod elongation;
mod mechanism;
mod results;
mod trial;

pub use arm::{ArmOptions, ArmPart, reproduce_arm};
pub use bench::{BenchOptions, BenchPart, Trace, reproduce_bench};
pub use elongation::{AvailableSensors, ElongationTable};
pub use mechanism::{Mechanism, Point};
pub use results::{
    BenchResults, ByVariant, Efficiency, ElongationMillimetres, Indices, OtherSpecimen, Sides, Stretching,
    WithoutJointEncoder,
};
pub use trial::{Recovery, Scores, TraceRow, Trial, run_trial};
