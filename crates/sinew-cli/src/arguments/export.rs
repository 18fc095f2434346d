//! Arguments of `sinew export`.

use super::machine::RootArgument;
use super::values::{SpecimenParser, SpecimenText};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Export a model for programs that are not this one: C sources, a functional mock-up unit, an ONNX graph.
///
/// `c` writes NAME.h and NAME.c (C99, no allocation, no library but sqrt), example.c (reads a CSV log and
/// prints what `sinew predict` writes), CMakeLists.txt, a wrapper for Simulink and a sketch for Arduino.
/// `fmu` and `fmu2` write NAME.fmu for co-simulation by FMI 3.0 and 2.0, with sources and, where a C
/// compiler is there, a binary for this platform. Every number is that of `sinew predict`, bit by bit.
/// `onnx` writes NAME.onnx, one sample with the state as an input and an output; clamp cells, regressions and
/// gated networks only.
///
/// With --inverse they command: the near side for a desired far side, bit by bit as `sinew compensate` does.
/// The C predicts as well, and `./a.out --inverse DESIRED.csv` prints commands; a unit takes the desired far
/// side as an input, and the near side where it is measured.
///
/// `sinew export twin` and `sinew export machine NAME` write units of simulated plants.
///
/// docs/export.md shows where a model can be used.
///
/// Example: sinew export out/sheath/model.json --to c --out sheath_c
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct ExportArguments {
    #[command(flatten)]
    pub(crate) model: Option<ModelExportArguments>,
    #[command(subcommand)]
    pub(crate) plant: Option<ExportVerb>,
}

/// Of a model.
#[derive(Debug, Args)]
pub(crate) struct ModelExportArguments {
    /// A model.json
    pub(crate) model: PathBuf,
    /// What to write
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) to: ExportForm,
    /// Folder for the files; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Name of files, types and functions: a C identifier [default: the name of the model's file]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Export the inverse, the near-side command for a desired far side
    #[arg(long)]
    pub(crate) inverse: bool,
    /// Largest rate of the command, in its unit per second [default: as of `sinew compensate`]
    #[arg(long, value_name = "RATE", requires = "inverse")]
    pub(crate) max_rate: Option<f64>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ExportVerb {
    Twin(Box<TwinExportArguments>),
    Machine(MachineExportArguments),
    /// Simulate the plant of a unit, with numbers of 64 bits on standard input and output; units start this.
    #[command(hide = true)]
    Serve {
        /// The unit's resources/plant.json
        file: PathBuf,
    },
}

/// Export the simulated bench's cable as a unit: motion of both ends in, tensions out.
///
/// The unit starts this program, which has to be found on PATH where the unit is used.
///
/// Example: sinew export twin --to fmu --out cable_fmu
#[derive(Debug, Args)]
pub(crate) struct TwinExportArguments {
    #[command(flatten)]
    pub(crate) unit: UnitArguments,
    /// Cable: a named one, or a seed N that draws another one at random
    #[arg(long, value_name = "NAME|N", default_value = "bench", value_parser = SpecimenParser)]
    pub(crate) specimen: SpecimenText,
    /// Initial far tension, N, at least the cable's pretension, as after sliding toward the motor
    #[arg(long, value_name = "N", default_value_t = 40.0)]
    pub(crate) start: f64,
}

/// Export a simulated machine as a unit: speeds of its cables in, readings of its sensors out.
///
/// The plant alone, without a controller: bodies, cables, drives, sensors. The unit holds the machine's files
/// and starts this program, which has to be found on PATH where the unit is used.
///
/// Example: sinew export machine bench_joint --to fmu --out joint_fmu
#[derive(Debug, Args)]
pub(crate) struct MachineExportArguments {
    /// A machine file, or the name of a built-in machine
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    #[command(flatten)]
    pub(crate) unit: UnitArguments,
    /// Seed of the specimen and of the sensor noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Of a unit of a plant.
#[derive(Debug, Args)]
pub(crate) struct UnitArguments {
    /// What to write
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) to: UnitForm,
    /// Folder for the unit; created if missing
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Name of the unit: a C identifier [default: cable, or the name of the machine]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
}

/// Versions of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum UnitForm {
    /// Co-simulation by FMI 3.0
    Fmu,
    /// Co-simulation by FMI 2.0
    Fmu2,
}

/// What an export gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportForm {
    /// C99 sources
    C,
    /// A functional mock-up unit for co-simulation by FMI 3.0
    Fmu,
    /// The same by FMI 2.0
    Fmu2,
    /// An ONNX graph of one sample
    Onnx,
}
