//! What identifies a machine's devices, on whatever bus they are.

use crate::ethercat::{self, EthercatDevice};
use crate::servos::{self, ServoDevice};
use sinew::description::DescriptionError;
use sinew::description::machine::{BusKeys, BusReader, Listing, Table};
use sinew::machine::Machine;

/// The devices of a machine on each bus that they can be on; none on a bus that its file does not speak of.
#[derive(Debug, Clone, Default)]
pub struct Devices {
    /// On EtherCAT.
    pub ethercat: Vec<EthercatDevice>,
    /// Serial servos.
    pub servos: Vec<ServoDevice>,
}

/// Reads what identifies the devices of a machine file: those with an `id` are servos, others on EtherCAT.
#[derive(Debug, Clone, Default)]
pub struct DeviceTables {
    ethercat: ethercat::DeviceTables,
    servos: servos::DeviceTables,
    count: usize,
}

impl DeviceTables {
    /// The devices of the machine that was read; simulated ones on every bus where its file names none.
    ///
    /// # Errors
    /// A value that contradicts the device's model.
    pub fn devices(&self, machine: &Machine) -> Result<Devices, DescriptionError> {
        let any = self.count == 0;
        Ok(match self.servos.is_empty() {
            true if any => Devices {
                ethercat: EthercatDevice::simulated(machine),
                servos: ServoDevice::simulated(machine),
            },
            true => Devices { ethercat: self.ethercat.devices(machine), servos: Vec::new() },
            false => Devices { ethercat: Vec::new(), servos: self.servos.devices(machine)? },
        })
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        BusKeys {
            device: &[
                "id",
                "model",
                "port",
                "baud",
                "vendor",
                "product",
                "revision",
                "revision_rule",
                "alias",
            ],
            drive: &["operating_mode", "synchronization"],
            channel: &["value", "status"],
        }
    }

    fn read(
        &mut self,
        device: &Table<'_>,
        channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError> {
        let [servo, other] = ["id", "vendor"].map(|key| device.entry(key));
        let (is_servo, first) = (servo.is_some(), self.count == 0);
        let other_kind =
            if self.servos.is_empty() { servo.as_ref().filter(|_| !first) } else { other.as_ref() };
        if let Some(entry) = other_kind {
            return Err(entry.refuse("devices of one bus: all servos, or all on EtherCAT"));
        }
        self.count += 1;
        if is_servo || !self.servos.is_empty() {
            self.servos.read(device, channels, listing)
        } else {
            self.ethercat.read(device, channels, listing)
        }
    }
}
