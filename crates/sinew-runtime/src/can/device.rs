//! What identifies a machine's nodes.

use super::error::CanError;
use super::mit::MitMotor;
use sinew::drive::DriveParameters;
use sinew::machine::{DeviceRole, DriveDevice, Machine};

/// What a node speaks; all on one bus speak the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// CANopen, with a drive after CiA 402.
    Canopen,
    /// CANSimple of ODrive's firmware 0.6.
    Cansimple,
    /// Registers of a moteus, on CAN FD.
    Moteus,
    /// MIT mode: mini cheetah, CubeMars, DAMIAO.
    Mit,
}

/// A drive of the machine that is a node on CAN.
#[derive(Debug, Clone, PartialEq)]
pub struct CanDevice {
    /// Index in the machine's list of devices.
    pub device: usize,
    /// As messages name it.
    pub name: String,
    /// What it does for the machine.
    pub drive: DriveDevice,
    /// What it speaks.
    pub protocol: Protocol,
    /// Its identifier: 1 to 126, on CANSimple 0 to 62.
    pub node: u8,
    /// On CANopen vendor ID and product code that it has to have, where they are said.
    pub identity: [Option<u32>; 2],
    /// On CANSimple the file with the numbers of its parameters; none: they are not read back.
    pub endpoints: Option<String>,
    /// Of a motor in MIT mode, what it is.
    pub mit: Option<MitMotor>,
    /// Serial port of an adapter, or CAN interface; none: the one that the program is given.
    pub port: Option<String>,
    /// Rate of the bus, bit/s.
    pub bitrate: u32,
}

/// Rate of a bus of which none is said, bit/s.
pub(super) const BITRATE: u32 = 1_000_000;
/// The master's own identifier, whose heartbeat the nodes watch.
pub(super) const MASTER: u8 = 127;

impl CanDevice {
    /// The nodes of a machine whose file names no devices: node n on CANopen drives muscle n, from 1, at 1
    /// Mbit/s on the adapter that the program is given.
    #[must_use]
    pub fn simulated(machine: &Machine) -> Vec<Self> {
        let node = |(device, of): (usize, &sinew::machine::Device)| {
            let DeviceRole::Drive(drive) = of.role else { return None };
            let (name, node) = (of.name.clone(), drive.muscle as u8 + 1);
            let protocol = Protocol::Canopen;
            Some(Self {
                device,
                name,
                drive,
                protocol,
                node,
                identity: [None; 2],
                endpoints: None,
                mit: None,
                port: None,
                bitrate: BITRATE,
            })
        };
        machine.devices.iter().enumerate().filter_map(node).collect()
    }

    /// The same node with another protocol; those but CANopen show turns of the motor, in MIT mode of the
    /// winch as a DM-J4310, in the direction that its counts have.
    #[must_use]
    pub fn on(mut self, protocol: Protocol, machine: &Machine) -> Self {
        self.protocol = protocol;
        let drive = machine.muscles[self.drive.muscle].drive;
        if protocol != Protocol::Canopen {
            self.drive.counts_per_turn = 1_f64.copysign(self.drive.counts_per_turn);
        }
        if protocol == Protocol::Mit {
            self.drive.counts_per_turn /= drive.reducer.ratio;
            self.drive.offset = middle(&drive);
            let [stiffness, damping] = MitMotor::gains(&drive, self.drive.counts_per_turn);
            let (model, ranges) = MitMotor::USUAL;
            self.mit = Some(MitMotor { model: model.to_owned(), ranges, stiffness, damping });
        }
        self
    }

    /// What a motor in MIT mode is.
    pub(super) fn motor(&self) -> Result<&MitMotor, CanError> {
        self.mit.as_ref().ok_or_else(|| self.wrong("its model is not said"))
    }

    /// That its port cannot be used.
    pub(super) fn unusable(&self, source: std::io::Error) -> CanError {
        CanError::Port { port: self.port.clone().unwrap_or_else(|| "the adapter".to_owned()), source }
    }

    /// That something is wrong with it.
    pub(super) fn wrong(&self, problem: impl Into<String>) -> CanError {
        CanError::Node { device: self.name.clone(), node: self.node, problem: problem.into() }
    }
}

/// Angle of the motor with half of the drum wound, rad.
pub(super) fn middle(drive: &DriveParameters) -> f64 {
    0.5 * drive.winch.full() * drive.reducer.ratio
}
