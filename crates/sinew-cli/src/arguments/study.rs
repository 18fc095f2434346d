//! Arguments of `sinew study`.

use clap::Args;
use std::path::PathBuf;

/// Print the Python program that runs a study: many designs or simulated specimens, on threads, Ray or Slurm.
///
/// The file (TOML) names the objective, the ranges of its parameters, the number of trials and where they run; docs/study.md
/// describes its keys. Running needs the Python package `sinew` (`pip install .`). An interrupted study resumes when its program
/// is started again.
///
/// Example: sinew study robustness.toml > robustness.py, then python robustness.py
#[derive(Debug, Args)]
pub(crate) struct StudyArguments {
    /// A study
    #[arg(value_name = "FILE.toml")]
    pub(crate) file: PathBuf,
}
