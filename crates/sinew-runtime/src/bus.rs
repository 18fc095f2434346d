use crate::devices::Devices;
use sinew::machine::Machine;
use sinew_session::{BusFault, Plant};

/// A bus that a real machine can be on.
#[derive(Debug, Clone, Copy)]
pub struct Bus {
    /// In arguments and messages.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether an interface has to be named, which the machine file does not.
    pub needs_interface: bool,
    /// Opens the interface of this name, empty where none is named, on which nothing has power yet.
    pub open: fn(&str) -> Result<Box<dyn Wire>, BusError>,
    /// The code of a fault in words, which follow the name of the device where there is one.
    pub words: fn(BusFault) -> String,
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
