//! The native part of the Python package `sinew`: arrays in, the libraries of this repository, arrays out.
//!
//! | file             | what it gives Python                                                         |
//! |------------------|------------------------------------------------------------------------------|
//! | `logs`, `model`  | identification, scores and predictions of logs                               |
//! | `predictor`      | one prediction per sample                                                    |
//! | `machine`        | geometry and dynamics of machines, in one pose or many                       |
//! | `tension`        | distribution of torques over muscles                                         |
//! | `cable`, `twin`  | one cable, a simulated machine                                               |
//! | `twins`          | many simulated machines, stepped together                                    |
//! | `controller`     | the controller of a machine                                                  |
//! | `environments`   | environments for reinforcement learning                                      |
//! | `worlds`         | environments as numbers for a simulator of many worlds                       |
//! | `mujoco`         | the way to the plugins for MuJoCo                                            |
//! | `track`, `reproduction` | whole experiments                                                     |
//! | `array`          | NumPy arrays without copies                                                  |
//! | `long_call`      | calls without the interpreter's lock that Ctrl-C ends                        |
//! | `failure`        | errors as exceptions                                                         |
//!
//! What a user sees is the Python face in `python/sinew`: it has the defaults, the keywords and the display.

mod array;
mod cable;
mod compensator;
mod controller;
mod environments;
mod failure;
mod logs;
mod long_call;
mod machine;
mod model;
mod mujoco;
mod predictor;
mod reproduction;
mod tension;
mod track;
mod twin;
mod twins;
mod worlds;

/// The native module.
#[pyo3::pymodule]
mod _sinew {
    use pyo3::prelude::*;

    /// Adds the version.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use crate::cable::{Cable, CableEnds};
    #[pymodule_export]
    use crate::compensator::{Compensator, NearCommand};
    #[pymodule_export]
    use crate::controller::{Command, Controller};
    #[pymodule_export]
    use crate::environments::Environments;
    #[pymodule_export]
    use crate::logs::table_text;
    #[pymodule_export]
    use crate::machine::Machine;
    #[pymodule_export]
    use crate::model::{Model, demo_logs, identify};
    #[pymodule_export]
    use crate::mujoco::{mujoco_connect_address, mujoco_fields, mujoco_machine};
    #[pymodule_export]
    use crate::predictor::{Prediction, Predictor};
    #[pymodule_export]
    use crate::reproduction::{page_style, reproduce};
    #[pymodule_export]
    use crate::tension::distribute;
    #[pymodule_export]
    use crate::track::{Trajectory, plan_motion, track, verify};
    #[pymodule_export]
    use crate::twin::Twin;
    #[pymodule_export]
    use crate::twins::TwinBatch;
}
