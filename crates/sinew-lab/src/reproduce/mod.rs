//! The paper's experiments on the twin: its tables and figures in our numbers. Everything here is simulated.

mod arm;
mod bench;
mod elongation;
mod mechanism;
mod results;
mod trial;

pub use arm::{ArmOptions, ArmPart, reproduce_arm};
pub use bench::{BenchOptions, BenchPart, Trace, reproduce_bench};
pub use elongation::{ElongationTable, Reach};
pub use mechanism::{Mechanism, Point};
pub use results::{
    BenchResults, ByVariant, Efficiency, ElongationMillimetres, Indices, OtherSpecimen, Sides, Stretching,
};
pub use trial::{Recovery, Scores, TraceRow, Trial, on_trial};
