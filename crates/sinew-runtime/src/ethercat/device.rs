//! What identifies a machine's devices on EtherCAT, and where their numbers stand.

use crate::cia402::ObjectAddress;
use sinew::machine::{Device, DeviceRole, Machine, SensorChannel, Signal};

/// A device of the machine on EtherCAT.
#[derive(Debug, Clone, PartialEq)]
pub struct EthercatDevice {
    /// Its name, and what it does for the machine.
    pub device: Device,
    /// What has to answer at its place.
    pub identity: DeviceIdentity,
    /// Station alias that it has; without one it is identified by its place on the wire.
    pub alias: Option<u16>,
    /// Whether a drive with a distributed clock takes its set-points over at SYNC0, once a period, or as they
    /// come.
    pub sync0: bool,
    /// Of its channels, in their order.
    pub objects: Vec<ChannelObjects>,
}

/// Identity of a device, as in its EEPROM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceIdentity {
    /// Vendor ID.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision number.
    pub revision: u32,
    /// Which revisions can take its place.
    pub rule: RevisionRule,
}

/// Which revisions of a device are accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RevisionRule {
    /// The same.
    Exact,
    /// The same or a later one.
    AtLeast,
    /// Every one.
    Any,
}

impl DeviceIdentity {
    /// Whether a device with this vendor ID, product code and revision number is accepted.
    #[must_use]
    pub fn accepts(&self, [vendor, product, revision]: [u32; 3]) -> bool {
        let fits = match self.rule {
            RevisionRule::Exact => revision == self.revision,
            RevisionRule::AtLeast => revision >= self.revision,
            RevisionRule::Any => true,
        };
        vendor == self.vendor && product == self.product && fits
    }
}

/// Objects of a sensor in the process data of its device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChannelObjects {
    /// Of the count.
    pub value: ObjectAddress,
    /// Of a status word, and the bits of it that mark a reading as invalid.
    pub status: Option<(ObjectAddress, u16)>,
}

/// Vendor ID of the simulated devices.
const VENDOR: u32 = 0x0005_1e37;
/// Product codes of the simulated drive, load-cell terminal and encoder terminal with no channel; their
/// revision.
const DRIVE: u32 = 0x0001_0402;
const LOAD_CELL: u32 = 0x0002_0001;
const ENCODERS: u32 = 0x0003_0000;
const REVISION: u32 = 0x0001_0000;

impl EthercatDevice {
    /// The devices of a machine whose file names none: the simulated ones of this project, in its order.
    #[must_use]
    pub fn simulated(machine: &Machine) -> Vec<Self> {
        machine.devices.iter().cloned().map(Self::stand_in).collect()
    }

    fn stand_in(device: Device) -> Self {
        let channels = device.channels();
        let product = match (&device.role, channels) {
            (DeviceRole::Drive(_), _) => DRIVE,
            (_, [one]) if matches!(one.signal, Signal::Tension(_)) => LOAD_CELL,
            (_, all) => ENCODERS + all.len() as u32,
        };
        Self {
            identity: DeviceIdentity {
                vendor: VENDOR,
                product,
                revision: REVISION,
                rule: RevisionRule::AtLeast,
            },
            alias: None,
            sync0: true,
            objects: (0..channels.len()).map(|place| ChannelObjects::simulated(place as u16)).collect(),
            device,
        }
    }

    /// As messages name it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.device.name
    }

    /// Its sensors with their objects.
    pub fn channels(&self) -> impl Iterator<Item = (&SensorChannel, &ChannelObjects)> {
        self.device.channels().iter().zip(&self.objects)
    }
}

impl ChannelObjects {
    /// Of a simulated terminal: its records begin at 0x6000 and are 16 apart, status and count.
    fn simulated(place: u16) -> Self {
        let index = 0x6000 + 0x10 * place;
        Self {
            value: ObjectAddress { index, subindex: 2 },
            status: Some((ObjectAddress { index, subindex: 1 }, u16::MAX)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_revision_is_accepted_by_its_rule() {
        let of = |rule| DeviceIdentity { vendor: 1, product: 2, revision: 3, rule };
        for (rule, accepted) in [
            (RevisionRule::Exact, [false, true, false]),
            (RevisionRule::AtLeast, [false, true, true]),
            (RevisionRule::Any, [true; 3]),
        ] {
            assert_eq!([2, 3, 4].map(|revision| of(rule).accepts([1, 2, revision])), accepted);
            assert!(!of(rule).accepts([1, 9, 3]) && !of(rule).accepts([9, 2, 3]));
        }
    }
}
