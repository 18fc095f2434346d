use sinew::description::DescriptionError;
use sinew::description::machine::BusReader;
use sinew::machine::Machine;
use sinew_session::{BusFault, Plant};
use std::any::Any;
use std::sync::Arc;

/// A bus that a real machine can be on.
#[derive(Debug, Clone, Copy)]
pub struct Bus {
    /// In arguments and messages.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether an interface has to be named, which the machine file does not.
    pub needs_interface: bool,
    /// Whether a cycle begins with readings from the end of the one before: its line has the whole period.
    pub reads_ahead: bool,
    /// Opens the interface of this name, empty where none is named, on which nothing has power yet.
    pub open: fn(&str) -> Result<Box<dyn Wire>, BusError>,
    /// The code of a fault in words, which follow the name of the device where there is one.
    pub words: fn(BusFault) -> String,
    /// What reads the tables of its devices; none where it finds them by their order.
    pub tables: Option<Tables>,
}

impl Bus {
    /// Age of its readings where a cycle of a period, s, begins, s.
    #[must_use]
    pub fn reading_age(&self, period: f64) -> f64 {
        if self.reads_ahead { period } else { 0.0 }
    }
}

/// How the tables of a bus's devices are told and read.
#[derive(Debug, Clone, Copy)]
pub struct Tables {
    /// A key that all its devices have; of a device with those of two buses, the later in the list counts.
    pub mark: &'static str,
    /// A reader that has read nothing.
    pub reader: fn() -> Box<dyn DeviceReader>,
}

/// Reads what identifies the devices of a machine file that are all on one bus.
pub trait DeviceReader: BusReader + std::fmt::Debug {
    /// The devices of the machine that was read; simulated ones where its file names none.
    ///
    /// # Errors
    /// A value that contradicts the machine or the device's model.
    fn devices(&self, machine: &Machine) -> Result<AnyDevices, DescriptionError>;
}

/// A `Vec` of the devices of one bus, in that bus's own type.
pub type AnyDevices = Arc<dyn Any + Send + Sync>;

/// The devices of a machine on each bus that they can be on; none on a bus that its file does not speak of.
#[derive(Debug, Clone, Default)]
pub struct Devices(pub(crate) Vec<AnyDevices>);

impl Devices {
    /// Those of a type, which belongs to one bus.
    #[must_use]
    pub fn of<T: 'static>(&self) -> &[T] {
        self.0.iter().find_map(|devices| devices.downcast_ref::<Vec<T>>()).map_or(&[], Vec::as_slice)
    }
}

/// Opens nothing: on this system the bus cannot be driven.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub(crate) fn open(_: &str) -> Result<Box<dyn Wire>, BusError> {
    Err(BusError::System("this bus can be driven on Linux alone".into()))
}

/// An open bus, on which nothing has power yet.
pub trait Wire {
    /// Finds the devices of a machine and gives its drives power, which hold still in the machine's period.
    /// Whoever drops the plant stops them.
    ///
    /// # Errors
    /// [`BusError`] names the device and what is wrong with it.
    fn operate<'a>(
        &'a mut self,
        machine: &Machine,
        devices: &Devices,
    ) -> Result<Box<dyn Plant + 'a>, BusError>;
}

/// Why a bus does not start, in the words of its room.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The system is the cause.
    #[error(transparent)]
    System(Box<dyn std::error::Error + Send + Sync>),
    /// Devices, interface or machine are not what was expected.
    #[error(transparent)]
    Unexpected(Box<dyn std::error::Error + Send + Sync>),
}
