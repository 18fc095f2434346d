//! The master before operation: what is on the wire, and whether it is what the machine file expects.

use super::bring_up::{self, PreOpGroup};
use super::error::{EthercatError, Mismatch};
use super::link::Link;
use super::operational::EthercatBus;
use super::pump::{FrameStorage, Pump};
use ethercrab::{MainDevice, MainDeviceConfig, RetryBehaviour, Timeouts};
use sinew::machine::{Device, Machine};
use std::time::Duration;

/// A master whose devices are not known yet.
pub struct Master<'a, L> {
    pub(super) main: MainDevice<'a>,
    pub(super) pump: Pump<'a, L>,
}

/// A device on the wire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundDevice {
    /// From 0.
    pub position: usize,
    /// Short name in its EEPROM.
    pub name: String,
    /// Vendor ID, product code, revision number.
    pub identity: [u32; 3],
    /// Serial number.
    pub serial: u32,
    /// Station alias; 0 is none.
    pub alias: u16,
}

/// A master whose devices, in PRE-OP, are those of the machine.
pub struct Matched<'a, L> {
    master: Master<'a, L>,
    group: PreOpGroup,
    /// Position of every device of the machine file.
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

/// Before operation a lost frame is sent again.
const RETRIES: usize = 3;
/// Rounds of the static compensation of the clocks' drift.
const CLOCK_ROUNDS: u32 = 500;

impl<'a, L: Link> Master<'a, L> {
    /// A master that sends its frames over a link.
    ///
    /// # Errors
    /// [`EthercatError::StorageInUse`] where another master has the memory.
    pub fn new(storage: &'a FrameStorage, link: L) -> Result<Self, EthercatError> {
        let (tx, rx, frames) = storage.split().ok_or(EthercatError::StorageInUse)?;
        let timeouts = Timeouts {
            pdu: Duration::from_millis(20),
            state_transition: Duration::from_secs(5),
            mailbox_echo: Duration::from_millis(500),
            ..Timeouts::default()
        };
        let config = MainDeviceConfig {
            dc_static_sync_iterations: CLOCK_ROUNDS,
            retry_behaviour: RetryBehaviour::Count(RETRIES),
        };
        Ok(Self { main: MainDevice::new(frames, timeouts, config), pump: Pump::new(tx, rx, link) })
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        self.pump.link_mut()
    }

    /// Brings all devices to PRE-OP and lists them in the order on the wire.
    ///
    /// # Errors
    /// [`EthercatError::Link`] and [`EthercatError::Protocol`] where they do not answer as they should.
    pub fn scan(&mut self) -> Result<Vec<FoundDevice>, EthercatError> {
        self.pre_op().map(|(_, found)| found)
    }

    /// Compares the devices on the wire with those of a machine.
    ///
    /// # Errors
    /// As [`scan`](Self::scan); [`EthercatError::NoDevices`] and [`EthercatError::Mismatch`]. The master is given back, to
    /// try again.
    pub fn match_devices(mut self, expected: &[Device]) -> Result<Matched<'a, L>, Refused<'a, L>> {
        match self.matching(expected) {
            Ok((group, positions)) => Ok(Matched { master: self, group, positions }),
            Err(error) => Err(Refused { master: Box::new(self), error }),
        }
    }

    fn matching(&mut self, expected: &[Device]) -> Result<(PreOpGroup, Vec<usize>), EthercatError> {
        let (group, found) = self.pre_op()?;
        if found.is_empty() {
            return Err(EthercatError::NoDevices { expected: expected.len() });
        }
        let positions = positions(expected, &found).map_err(EthercatError::Mismatch)?;
        Ok((group, positions))
    }

    pub(super) fn pre_op(&mut self) -> Result<(PreOpGroup, Vec<FoundDevice>), EthercatError> {
        let Self { main, pump } = self;
        let outcome = pump.complete(bring_up::pre_op(main));
        outcome.map_err(|error| match pump.take_error() {
            Some(source) => EthercatError::Link { during: "looking for devices", source },
            None => error,
        })
    }
}

/// The position of every expected device: first those with a station alias, then the others in their order.
pub(super) fn positions(expected: &[Device], found: &[FoundDevice]) -> Result<Vec<usize>, Vec<Mismatch>> {
    let by_alias = |device: &Device| {
        device
            .alias
            .and_then(|alias| found.iter().find(|found| found.alias == alias))
            .map(|found| found.position)
    };
    let aliased: Vec<Option<usize>> = expected.iter().map(by_alias).collect();
    let mut free = found.iter().filter(|found| !aliased.contains(&Some(found.position)));
    let (mut positions, mut mismatches) = (Vec::new(), Vec::new());
    for (k, (device, alias)) in expected.iter().zip(&aliased).enumerate() {
        let found = match alias {
            Some(position) => found.get(*position),
            None if device.alias.is_some() => None,
            None => free.next(),
        };
        match found {
            Some(found) if device.identity.accepts(found.identity) => positions.push(found.position),
            other => mismatches.push(Mismatch {
                position: other.map_or(k, |found| found.position),
                expected: Some((device.name.clone(), device.identity)),
                found: other.map(|found| (found.name.clone(), found.identity)),
            }),
        }
    }
    mismatches.extend(free.map(|found| Mismatch {
        position: found.position,
        expected: None,
        found: Some((found.name.clone(), found.identity)),
    }));
    if mismatches.is_empty() { Ok(positions) } else { Err(mismatches) }
}

/// What differs between the devices of a machine file and those on the wire; empty where nothing does.
#[must_use]
pub fn compare(expected: &[Device], found: &[FoundDevice]) -> Vec<Mismatch> {
    positions(expected, found).err().unwrap_or_default()
}

impl<'a, L: Link> Matched<'a, L> {
    /// Configures the devices for a period of the cycle, ns, brings them to OP and enables the drives, which hold still.
    ///
    /// # Errors
    /// [`EthercatError`] names the device and what is wrong with it.
    pub fn operate(self, machine: &Machine, period: u64) -> Result<EthercatBus<'a, L>, EthercatError> {
        EthercatBus::start(self.master, self.group, &self.positions, machine, period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::machine::{DeviceIdentity, DeviceRole, RevisionRule};

    fn device(name: &str, product: u32, alias: Option<u16>) -> Device {
        let identity = DeviceIdentity { vendor: 1, product, revision: 0, rule: RevisionRule::Any };
        Device { name: name.into(), identity, alias, role: DeviceRole::Sensors(vec![]) }
    }

    fn found(position: usize, product: u32, alias: u16) -> FoundDevice {
        FoundDevice {
            position,
            name: format!("device {product}"),
            identity: [1, product, 0],
            serial: 0,
            alias,
        }
    }

    #[test]
    fn devices_are_found_by_their_alias_or_by_their_order() {
        let expected = [device("a", 10, None), device("b", 11, Some(7)), device("c", 12, None)];
        let wire = [found(0, 11, 7), found(1, 10, 0), found(2, 12, 0)];
        assert_eq!(positions(&expected, &wire), Ok(vec![1, 0, 2]));
    }

    #[test]
    fn wrong_order_missing_and_surplus_devices_are_named() {
        let expected = [device("a", 10, None), device("b", 11, None)];
        let swapped = positions(&expected, &[found(0, 11, 0), found(1, 10, 0)]).unwrap_err();
        assert_eq!(swapped.len(), 2);
        let text = EthercatError::Mismatch(swapped).to_string();
        assert!(text.contains("position 0: expected `a`") && text.contains("found `device 11`"), "{text}");
        let missing = positions(&expected, &[found(0, 10, 0)]).unwrap_err();
        assert!(EthercatError::Mismatch(missing).to_string().contains("found none"));
        let surplus = positions(&expected, &[found(0, 10, 0), found(1, 11, 0), found(2, 9, 0)]).unwrap_err();
        assert!(EthercatError::Mismatch(surplus).to_string().contains("position 2: expected no device"));
    }
}
