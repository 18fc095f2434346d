//! Arguments of a session with a machine: what `sinew track` and `sinew run` share.

use super::link::RunLinkArguments;
use super::motion::MotionArguments;
use super::page::PageArguments;
use super::ros::RosArguments;
use clap::Args;
use std::path::PathBuf;

// The help of the verb stands with the verb: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct SessionArguments {
    #[command(flatten)]
    pub(crate) motion: MotionArguments,
    #[command(flatten)]
    pub(crate) link: RunLinkArguments,
    /// Record every cycle (MCAP), see `sinew log` and `sinew log replay`; or write a simulated run as a table
    /// (CSV), one row per 10 ms
    #[arg(long, value_name = "FILE.mcap|FILE.csv")]
    pub(crate) record: Option<PathBuf>,
    /// Write an HTML report of a simulated run
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) page: PageArguments,
    #[command(flatten)]
    pub(crate) ros: RosArguments,
}
