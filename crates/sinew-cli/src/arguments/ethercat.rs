//! Arguments of `sinew ethercat`.

use super::machine::RootArgument;
use super::values::number;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// A machine's devices on EtherCAT: what is on the wire, and simulated devices for other masters.
#[derive(Debug, Args)]
pub(crate) struct EthercatArguments {
    #[command(subcommand)]
    pub(crate) verb: EthercatVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum EthercatVerb {
    Scan(EthercatScanArguments),
    Simulate(EthercatSimulateArguments),
}

/// List the devices on the wire beside those that the machine file expects.
///
/// The devices are brought to PRE-OP; nothing moves. Ends with exit code 3 where the wire differs from the
/// file.
///
/// Example: sinew ethercat scan lm_arm --interface eth1
#[derive(Debug, Args)]
pub(crate) struct EthercatScanArguments {
    /// A machine's file, or the name of a built-in machine
    #[arg(default_value = "lm_arm")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Network interface
    #[arg(long, value_name = "IF")]
    pub(crate) interface: String,
}

/// Answer another master with the simulated devices of a machine, whose twin moves behind them.
///
/// The machine starts in its start pose with closed brakes. Ctrl-C ends it.
///
/// Example: sinew ethercat simulate planar_leg --interface veth1
#[derive(Debug, Args)]
pub(crate) struct EthercatSimulateArguments {
    /// A machine's file, or the name of a built-in machine
    #[arg(default_value = "lm_arm")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Network interface
    #[arg(long, value_name = "IF")]
    pub(crate) interface: String,
    #[command(flatten)]
    pub(crate) devices: DeviceFileArguments,
    /// Seed of the machine's deviations from its design
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// CSV file for the true joints and tensions of the simulated machine, a row every 10 ms
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Seconds after which it ends, 0.1 to 86400 [default: never]
    #[arg(long, value_name = "SECONDS",
        value_parser = number("0.1 to 86400 s", |s| (0.1..=86_400.0).contains(&s)))]
    pub(crate) duration: Option<f64>,
}

/// Descriptions of vendors' devices that are simulated.
#[derive(Debug, Args)]
pub(crate) struct DeviceFileArguments {
    /// ESI file of a vendor, or device table in TOML: the machine's devices with its vendor ID and product
    /// code are simulated as it describes them; may be repeated
    #[arg(long = "device", value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
}
