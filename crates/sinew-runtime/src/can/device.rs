//! What identifies a machine's nodes.

use super::error::CanError;
use sinew::machine::{DeviceRole, DriveDevice, Machine};

/// A drive of the machine that is a node on CAN.
#[derive(Debug, Clone, PartialEq)]
pub struct CanDevice {
    /// Index in the machine's list of devices.
    pub device: usize,
    /// As messages name it.
    pub name: String,
    /// What it does for the machine.
    pub drive: DriveDevice,
    /// Its identifier, 1 to 126.
    pub node: u8,
    /// Vendor ID and product code that it has to have, where they are said.
    pub identity: [Option<u32>; 2],
    /// Serial port of the adapter; none: the one that the program is given.
    pub port: Option<String>,
    /// Rate of the bus, bit/s.
    pub bitrate: u32,
}

/// Rate of a bus of which none is said, bit/s.
pub(super) const BITRATE: u32 = 1_000_000;
/// The master's own identifier, whose heartbeat the nodes watch.
pub(super) const MASTER: u8 = 127;

impl CanDevice {
    /// The nodes of a machine whose file names no devices: node n drives muscle n, from 1, at 1 Mbit/s on the
    /// adapter that the program is given.
    #[must_use]
    pub fn simulated(machine: &Machine) -> Vec<Self> {
        let node = |(device, of): (usize, &sinew::machine::Device)| {
            let DeviceRole::Drive(drive) = of.role else { return None };
            let (name, node) = (of.name.clone(), drive.muscle as u8 + 1);
            Some(Self { device, name, drive, node, identity: [None; 2], port: None, bitrate: BITRATE })
        };
        machine.devices.iter().enumerate().filter_map(node).collect()
    }

    /// That something is wrong with it.
    pub(super) fn wrong(&self, problem: impl Into<String>) -> CanError {
        CanError::Node { device: self.name.clone(), node: self.node, problem: problem.into() }
    }
}
