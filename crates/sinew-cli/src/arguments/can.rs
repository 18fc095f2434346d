//! Arguments of `sinew can`.

use super::machine::RootArgument;
use super::servos::SimulatedMachineArguments;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// CAN drives: what is on a bus, and simulated drives for other masters.
#[derive(Debug, Args)]
pub(crate) struct CanArguments {
    #[command(subcommand)]
    pub(crate) verb: CanVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum CanVerb {
    Scan(CanScanArguments),
    Simulate(CanSimulateArguments),
}

/// List the nodes that answer on a bus: those on CANSimple (ODrive) with their versions, or else those on
/// CANopen with name, vendor, product, profile; with --fd those of moteus with model and firmware, with --mit
/// motors in MIT mode.
///
/// Nothing moves and, but with --mit, nothing is written. Ends with exit code 3 where none answers.
///
/// Example: sinew can scan /dev/ttyACM0 --bitrate 500000
#[derive(Debug, Args)]
pub(crate) struct CanScanArguments {
    /// Serial port of an adapter (slcan, with --fd an fdcanusb), which has a slash, or a CAN interface such
    /// as can0
    #[arg(value_name = "PORT")]
    pub(crate) port: PathBuf,
    /// Rate of the bus, bit/s; that of an interface is set by the system
    #[arg(long, value_name = "RATE", default_value = "1000000", value_parser = rates())]
    pub(crate) bitrate: u32,
    /// Ask moteus controllers, by frames of CAN FD: 1 Mbit/s, octets at 5 Mbit/s
    #[arg(long, conflicts_with = "bitrate")]
    pub(crate) fd: bool,
    /// Ask motors in MIT mode (mini cheetah, CubeMars, DAMIAO) by telling them to leave it: those that have
    /// power lose it
    #[arg(long, conflicts_with = "fd")]
    pub(crate) mit: bool,
    /// Machine file beside whose devices they are listed; exit code 3 then also where one does not answer
    #[arg(long, value_name = "FILE")]
    pub(crate) machine: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) root: RootArgument,
}

fn rates() -> impl TypedValueParser<Value = u32> {
    const NAMES: [&str; 9] =
        ["10000", "20000", "50000", "100000", "125000", "250000", "500000", "800000", "1000000"];
    PossibleValuesParser::new(NAMES).try_map(|name| name.parse::<u32>())
}

/// Answer another master with the simulated CAN drives of a machine, whose twin moves behind them.
///
/// The first line is the path of the pseudo-terminal, which speaks slcan, with moteus the text of an
/// fdcanusb, or the port of --interface. Without devices in the machine's file, node n on CANopen drives its
/// muscle n, from 1, at 1 Mbit/s. The machine is held in its start pose until a drive is enabled. Ctrl-C ends
/// it.
///
/// Example: sinew can simulate finger --pty
///
/// Example: sinew can simulate finger --interface vcan0
#[derive(Debug, Args)]
pub(crate) struct CanSimulateArguments {
    #[command(flatten)]
    pub(crate) simulated: SimulatedMachineArguments,
    /// Answer on a CAN interface such as vcan0, or on the bus of an adapter on a serial port, which has a
    /// slash
    #[arg(long, value_name = "PORT", conflicts_with = "pty")]
    pub(crate) interface: Option<String>,
}
