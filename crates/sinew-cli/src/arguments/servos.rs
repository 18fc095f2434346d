//! Arguments of `sinew servos`.

use super::machine::RootArgument;
use super::values::number;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Serial servos: what is on a line, and simulated servos for other masters.
#[derive(Debug, Args)]
pub(crate) struct ServosArguments {
    #[command(subcommand)]
    pub(crate) verb: ServosVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ServosVerb {
    Scan(ServosScanArguments),
    Simulate(ServosSimulateArguments),
}

/// List the servos that answer on a serial port: identifier, model, firmware, hardware errors.
///
/// Dynamixels answer all at once; Feetechs are asked one by one, 3 s at every rate.
/// Nothing moves and nothing is written. Ends with exit code 3 where none answers.
///
/// Example: sinew servos scan /dev/ttyUSB0 --baud all
#[derive(Debug, Args)]
pub(crate) struct ServosScanArguments {
    /// Serial port
    #[arg(value_name = "PORT")]
    pub(crate) port: PathBuf,
    /// Rate of the line, bit/s, or all of them, one after the other
    #[arg(long, value_name = "RATE|all", default_value = "1000000", value_parser = rates())]
    pub(crate) baud: Rates,
    /// Machine file beside whose devices they are listed; exit code 3 then also where one does not answer
    #[arg(long, value_name = "FILE")]
    pub(crate) machine: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) root: RootArgument,
}

/// Rates that are tried.
#[derive(Debug, Clone)]
pub(crate) struct Rates(pub(crate) Vec<u32>);

fn rates() -> impl TypedValueParser<Value = Rates> {
    const NAMES: [&str; 14] = [
        "9600", "38400", "57600", "76800", "115200", "128000", "250000", "500000", "1000000", "2000000",
        "3000000", "4000000", "4500000", "all",
    ];
    PossibleValuesParser::new(NAMES).map(|name| match name.parse() {
        Ok(rate) => Rates(vec![rate]),
        Err(_) => Rates(NAMES.iter().filter_map(|name| name.parse().ok()).collect()),
    })
}

/// Answer another master with the simulated servos of a machine, whose twin moves behind them.
///
/// The first line is the path of the pseudo-terminal; a machine with several ports has one for each, a line
/// each, in the order of the file. Without devices in the machine's file, servo n drives its muscle n and has
/// identifier n, from 1, and the registers of an XM430-W350. The machine is held in its start pose until all
/// servos have torque. Ctrl-C ends it.
///
/// Example: sinew servos simulate finger --pty
#[derive(Debug, Args)]
pub(crate) struct ServosSimulateArguments {
    #[command(flatten)]
    pub(crate) simulated: SimulatedMachineArguments,
}

/// The machine behind simulated devices for another master.
#[derive(Debug, Args)]
pub(crate) struct SimulatedMachineArguments {
    /// A machine's file, or the name of a built-in machine
    #[arg(default_value = "finger")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// CSV file for the true joints and tensions of the simulated machine, a row every 10 ms
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Answer on pseudo-terminals, as without it
    #[arg(long)]
    pub(crate) pty: bool,
    /// Seed of the machine's deviations from its design
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Seconds after which it ends, 0.1 to 86400 [default: never]
    #[arg(long, value_name = "SECONDS",
        value_parser = number("0.1 to 86400 s", |s| (0.1..=86_400.0).contains(&s)))]
    pub(crate) duration: Option<f64>,
}
