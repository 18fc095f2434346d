//! Arguments of `sinew live`.

use super::machine::RootArgument;
use super::values::{compensation, number};
use clap::Args;
use sinew_lab::CompensationVariant;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Show a simulated machine on a page in the browser, and take hold of it there; or show a recording.
///
/// The page shows bodies and cables with the tension along each of them, the reference, and any signal over
/// time. Modes, a stop (space bar), another path, dragging the end point, pushes, a payload, faults, slow
/// motion, single steps and a second machine with another compensation beside the first are commanded from
/// it, through the supervisor.
///
/// A recording of `sinew run` is played: pause, slow motion, single cycles, any time, its modes, faults and
/// repeats as marks, a second recording of the same machine over it (--overlay).
///
/// Only this computer can open the page. With --bind and another address everybody can who has the token,
/// which is part of the address that is printed.
///
/// Example: sinew live planar_leg --open
///
/// Example: sinew live today.mcap --overlay yesterday.mcap
#[derive(Debug, Args)]
pub(crate) struct LiveArguments {
    /// A machine's or robot's file, the name of a built-in machine, or a recording (MCAP)
    #[arg(default_value = "lm_arm", value_name = "MACHINE|FILE.mcap")]
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Another recording to lay over a recording; can be given several times, the page chooses
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) overlay: Vec<PathBuf>,
    /// Address and port of the page; port 0 is any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8470")]
    pub(crate) bind: SocketAddr,
    /// Open the page in the browser
    #[arg(long)]
    pub(crate) open: bool,
    /// Serve Foxglove's protocol as well, on this loopback address; needs a program built with the feature
    /// foxglove
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) foxglove: Option<SocketAddr>,
    /// Motion at the start: a closed path of the machine by its name, or tour [default: the first named path,
    /// otherwise tour]
    #[arg(long, value_name = "NAME|tour")]
    pub(crate) path: Option<String>,
    /// Seconds for two turns of a closed path, 2 to 3600 s
    #[arg(long, value_name = "SECONDS", default_value_t = 23.0,
        value_parser = number("2 to 3600 s", |s| (2.0..=3600.0).contains(&s)))]
    pub(crate) duration: f64,
    /// Compensation of the cables' transmission losses
    #[arg(long, value_name = "NAME", default_value = "observer",
        value_parser = compensation(&CompensationVariant::ARM))]
    pub(crate) compensation: CompensationVariant,
    /// Seconds after which the program ends [default: with Ctrl-C]
    #[arg(long, value_name = "SECONDS", value_parser = number("0 to 1e6 s", |s| (0.0..=1e6).contains(&s)))]
    pub(crate) until: Option<f64>,
    /// Seed of the machine's deviations from the model and of the sensor noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}
