//! The master whose devices are those of the machine.

use super::bring_up::PreOpGroup;
use super::device::EthercatDevice;
use super::error::EthercatError;
use super::link::Link;
use super::master::{Master, matching};
use super::operational::EthercatBus;
use sinew::machine::Machine;

/// A master whose devices, in PRE-OP, are those of the machine.
pub struct Matched<'a, L> {
    master: Master<'a, L>,
    group: PreOpGroup,
    /// The devices of the machine file, and the position of each on the wire.
    devices: Vec<EthercatDevice>,
    positions: Vec<usize>,
}

/// Devices that are not those of the machine, and the master to look for them again.
pub struct Refused<'a, L> {
    /// The master.
    pub master: Box<Master<'a, L>>,
    /// What is wrong.
    pub error: EthercatError,
}

impl<L> std::fmt::Debug for Refused<'_, L> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Debug::fmt(&self.error, f)
    }
}

impl<L> From<Refused<'_, L>> for EthercatError {
    fn from(refused: Refused<'_, L>) -> Self {
        refused.error
    }
}

impl<'a, L: Link> Master<'a, L> {
    /// Compares the devices on the wire with those of a machine.
    ///
    /// # Errors
    /// As [`scan`](Self::scan); [`EthercatError::NoDevices`] and [`EthercatError::Mismatch`]. The master is
    /// given back, to try again.
    pub fn match_devices(mut self, expected: &[EthercatDevice]) -> Result<Matched<'a, L>, Refused<'a, L>> {
        match matching(&self.main, &mut self.pump, expected) {
            Ok((group, positions)) => {
                Ok(Matched { master: self, group, devices: expected.to_vec(), positions })
            }
            Err(error) => Err(Refused { master: Box::new(self), error }),
        }
    }
}

impl<'a, L: Link> Matched<'a, L> {
    /// Configures the devices for the machine's period, brings them to OP and enables the drives, which hold
    /// still.
    ///
    /// # Errors
    /// [`EthercatError`] names the device and what is wrong with it.
    pub fn operate(self, machine: &Machine) -> Result<EthercatBus<'a, L>, EthercatError> {
        let Self { master, group, devices, positions } = self;
        EthercatBus::start(master, group, (devices, &positions), machine)
    }
}
