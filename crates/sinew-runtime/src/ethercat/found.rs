//! Devices on the wire beside those that a machine file expects.

use super::device::EthercatDevice;
use super::error::Mismatch;

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

/// The position of every expected device: first those with a station alias, then the others in their order.
pub(super) fn positions(
    expected: &[EthercatDevice],
    found: &[FoundDevice],
) -> Result<Vec<usize>, Vec<Mismatch>> {
    let by_alias = |device: &EthercatDevice| {
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
                expected: Some((device.name().to_owned(), device.identity)),
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
pub fn compare(expected: &[EthercatDevice], found: &[FoundDevice]) -> Vec<Mismatch> {
    positions(expected, found).err().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ethercat::{DeviceIdentity, EthercatError, RevisionRule};
    use sinew::machine::{Device, DeviceRole};

    fn device(name: &str, product: u32, alias: Option<u16>) -> EthercatDevice {
        let identity = DeviceIdentity { vendor: 1, product, revision: 0, rule: RevisionRule::Any };
        let device = Device { name: name.into(), role: DeviceRole::Sensors(vec![]) };
        EthercatDevice { device, identity, alias, sync0: true, objects: vec![] }
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
