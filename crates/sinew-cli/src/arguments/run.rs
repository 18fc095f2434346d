//! Arguments of `sinew run`.

use super::ethercat::DeviceFileArguments;
use super::session::SessionArguments;
use clap::{Args, ValueEnum};

/// Run a machine: its control cycle once a period, on a simulated or a real bus.
///
/// twin is the simulated machine without wires; segment adds an EtherCAT master and simulated EtherCAT devices in this
/// process; ethercat drives the devices on a network interface, which the machine file describes. Everything is planned and
/// checked as by `sinew track` before the start. At the end the times of the cycle are shown.
///
/// On --virtual-time the cycle does not wait for its deadlines: the results are the same to the bit.
///
/// Example: sinew run --bus segment --virtual-time --duration 11.5 --repeats 1
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    #[command(flatten)]
    pub(crate) session: SessionArguments,
    /// Drives and sensors
    #[arg(long, value_enum, default_value_t = BusArgument::Twin)]
    pub(crate) bus: BusArgument,
    /// Network interface of the devices, for --bus ethercat
    #[arg(long, value_name = "IF", required_if_eq("bus", "ethercat"))]
    pub(crate) interface: Option<String>,
    #[command(flatten)]
    pub(crate) devices: DeviceFileArguments,
    /// Do not wait for deadlines; for simulated buses
    #[arg(long, conflicts_with = "interface")]
    pub(crate) virtual_time: bool,
}

/// Drives and sensors of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BusArgument {
    /// The simulated machine, without wires
    Twin,
    /// The same behind an EtherCAT master and simulated EtherCAT devices
    Segment,
    /// Devices on a network interface
    Ethercat,
}

impl BusArgument {
    /// As it is given.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Twin => "twin",
            Self::Segment => "segment",
            Self::Ethercat => "ethercat",
        }
    }
}
