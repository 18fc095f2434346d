//! Arguments of `sinew run`.

use super::ethercat::DeviceFileArguments;
use super::session::SessionArguments;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use sinew_runtime::{BUSES, Bus, can, ethercat, servos};
use sinew_session::BusFault;

/// Run a machine: its control cycle once a period, on a simulated or a real bus.
///
/// twin is the simulated machine without wires; segment adds an EtherCAT master and simulated EtherCAT
/// devices in this process, chain a master of serial servos and simulated servos, nodes a CAN master and
/// simulated drives; ethercat drives the devices on a network interface, servos those on serial ports, can
/// those behind a serial adapter or on a CAN interface, which the machine file describes. Everything is
/// planned and checked as by `sinew track` before the start. At the end the times of the cycle are shown.
///
/// On --virtual-time the cycle does not wait for its deadlines: the results are bit-identical.
///
/// Example: sinew run --bus segment --virtual-time --duration 11.5 --repeats 1
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    #[command(flatten)]
    pub(crate) session: SessionArguments,
    /// Drives and sensors
    #[arg(long, value_parser = buses(), default_value = TWIN.0)]
    pub(crate) bus: BusArgument,
    /// Network interface of the devices, for --bus ethercat; serial port of servos, or of a CAN adapter,
    /// or CAN interface, whose table names none
    #[arg(long, value_name = "IF", required_if_eq_any(
        BUSES.iter().filter(|bus| bus.needs_interface).map(|bus| ("bus", bus.name))))]
    pub(crate) interface: Option<String>,
    #[command(flatten)]
    pub(crate) devices: DeviceFileArguments,
    /// Do not wait for deadlines; for simulated buses
    #[arg(long, conflicts_with = "interface")]
    pub(crate) virtual_time: bool,
}

/// Drives and sensors of a machine.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BusArgument {
    /// The simulated machine, without wires.
    Twin,
    /// The same behind an EtherCAT master and simulated EtherCAT devices.
    Segment,
    /// The same behind a master of serial servos and simulated servos.
    Chain,
    /// The same behind a CAN master and simulated drives.
    Nodes,
    /// A real machine.
    Real(&'static Bus),
}

/// Names of those that are simulated, and what they are.
const TWIN: (&str, &str) = ("twin", "The simulated machine, without wires");
const SEGMENT: (&str, &str) =
    ("segment", "The same behind an EtherCAT master and simulated EtherCAT devices");

const CHAIN: (&str, &str) = ("chain", "The same behind a master of serial servos and simulated servos");
const NODES: (&str, &str) =
    ("nodes", "The same behind a CAN master and simulated drives (CANopen, CANSimple)");

/// Those that are simulated, and every real one.
fn buses() -> impl TypedValueParser<Value = BusArgument> {
    let real = BUSES.iter().map(|bus| (bus.name, bus.about));
    let values = [TWIN, SEGMENT, CHAIN, NODES].into_iter().chain(real);
    let values = values.map(|(name, about)| PossibleValue::new(name).help(about));
    PossibleValuesParser::new(values).map(|name| match BUSES.iter().find(|bus| bus.name == name) {
        Some(bus) => BusArgument::Real(bus),
        None if name == SEGMENT.0 => BusArgument::Segment,
        None if name == CHAIN.0 => BusArgument::Chain,
        None if name == NODES.0 => BusArgument::Nodes,
        None => BusArgument::Twin,
    })
}

impl BusArgument {
    /// As it is given.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Twin => TWIN.0,
            Self::Segment => SEGMENT.0,
            Self::Chain => CHAIN.0,
            Self::Nodes => NODES.0,
            Self::Real(bus) => bus.name,
        }
    }

    /// Whether a machine is simulated behind it.
    pub(crate) fn is_simulated(self) -> bool {
        !matches!(self, Self::Real(_))
    }

    /// The real one, or the one that is simulated.
    pub(crate) fn real(self) -> Option<&'static Bus> {
        match self {
            Self::Twin => None,
            Self::Segment => Some(&ethercat::BUS),
            Self::Chain => Some(&servos::BUS),
            Self::Nodes => Some(&can::BUS),
            Self::Real(bus) => Some(bus),
        }
    }

    /// The code of a fault in its words.
    pub(crate) fn words(self, fault: BusFault) -> String {
        (self.real().unwrap_or(&ethercat::BUS).words)(fault)
    }
}
