//! Arguments of `sinew replay`.

use clap::Args;
use std::path::PathBuf;

/// Run the controller again over the readings of a recording, and show where its commands differ.
///
/// The same build commands the same to the bit. With --machine or --gains the commands of another controller are compared
/// with those of the recorded one, cycle by cycle, over the same readings.
///
/// Example: sinew replay run.mcap --gains softer.json --report differences.html
#[derive(Debug, Args)]
pub(crate) struct ReplayArguments {
    /// A recording
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// Another machine file or built-in machine for the controller
    #[arg(long, value_name = "MACHINE")]
    pub(crate) machine: Option<PathBuf>,
    /// Other gains (JSON, as `sinew machine tune` writes them)
    #[arg(long, value_name = "FILE.json")]
    pub(crate) gains: Option<PathBuf>,
    /// Write a page with the commands of both
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}
