//! Arguments of `sinew export`.

use clap::{Args, ValueEnum};
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
/// side as an input, and its drive to follow.
///
/// docs/export.md shows where a model can be used.
///
/// Example: sinew export out/sheath/model.json --to c --out sheath_c
#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
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
