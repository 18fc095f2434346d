//! A node before it takes commands: found, compared, configured, and everything read back.

use super::sdo::{SdoClient, SdoError};
use super::slot::CanopenSlot;
use super::{HEARTBEAT_MS, PRE_OPERATIONAL, TO_MASTER, TO_NODE, manage};
use crate::can::Link;
use crate::can::device::{CanDevice, MASTER};
use crate::can::error::{CanError, TWO_ANSWER};
use crate::can::slot::Slot;
use crate::cia402::{
    CONTROLWORD, DriveSlot, MODE, Mapping, POSITION, STATUSWORD, TARGET_VELOCITY, TORQUE, mode_of_operation,
};
use sinew::machine::{DriveMode, Machine};

/// What a PDO of a node carries: 6 octets to it, 8 from it, both with SYNC.
const OUTPUTS: [u32; 2] = [entry(CONTROLWORD, 16), entry(TARGET_VELOCITY, 32)];
const INPUTS: [u32; 3] = [entry(STATUSWORD, 16), entry(POSITION, 32), entry(TORQUE, 16)];
/// Profile of a drive, in the device type.
const PROFILE: u32 = 402;
/// Bit of a PDO's COB-ID: it does not exist.
const INVALID: u32 = 1 << 31;
/// Time in which a second node of the same identifier has answered, ns.
const TWICE: u64 = 5_000_000;

const fn entry(index: u16, bits: u32) -> u32 {
    (index as u32) << 16 | bits
}

/// Finds a node, compares it and sets it up for a machine. Nothing moves.
pub(in crate::can) fn start<L: Link>(
    link: &mut L,
    device: &CanDevice,
    machine: &Machine,
) -> Result<Box<dyn Slot>, CanError> {
    Configuring { client: &mut SdoClient::new(link), device }.configure(machine)?;
    let (mut outputs, mut inputs) = (Mapping::default(), Mapping::default());
    OUTPUTS.iter().for_each(|entry| outputs.push(*entry));
    INPUTS.iter().for_each(|entry| inputs.push(*entry));
    let parameters = machine.muscles[device.drive.muscle].drive;
    let drive = DriveSlot::new(&device.name, device.drive, parameters, [&outputs, &inputs]);
    let drive = drive.map_err(|error| device.wrong(error.to_string()))?;
    Ok(Box::new(CanopenSlot::new(device.node, drive)))
}

/// A node that is being configured.
struct Configuring<'a, 'b, L> {
    client: &'b mut SdoClient<'a, L>,
    device: &'b CanDevice,
}

impl<L: Link> Configuring<'_, '_, L> {
    fn configure(&mut self, machine: &Machine) -> Result<(), CanError> {
        let node = self.device.node;
        let port = |source| self.device.unusable(source);
        self.client.link.send(&[manage(PRE_OPERATIONAL, node)]).map_err(port)?;
        let profile = self.read(0x1000, 0)? & 0xffff;
        if self.client.answers_twice(node, TWICE).map_err(port)? {
            return Err(self.device.wrong(TWO_ANSWER));
        }
        if profile != PROFILE {
            return Err(self
                .device
                .wrong(format!("device profile {profile}: expected a drive, CiA {PROFILE}")));
        }
        for (expected, (name, subindex)) in self.device.identity.iter().zip([("vendor", 1), ("product", 2)]) {
            let Some(expected) = expected else { continue };
            let got = self.read(0x1018, subindex)?;
            if got != *expected {
                return Err(self.device.wrong(format!("{name} {got:#x}: expected {expected:#x}")));
            }
        }
        self.pdo(0x1400, TO_NODE, &OUTPUTS)?;
        self.pdo(0x1800, TO_MASTER, &INPUTS)?;
        for index in (0x1401..0x1404).chain(0x1801..0x1804) {
            self.if_there(index, 1, |id| (id | INVALID, 4))?;
        }
        let mode = mode_of_operation(DriveMode::Velocity);
        self.set(MODE, 0, (mode as u32, 1))?;
        let period_us = (1e6 * machine.period).round() as u32;
        self.if_there(0x1006, 0, |_| (period_us, 4))?;
        // In ms, as far as its octet goes.
        let period_ms = (1e3 * machine.period).round().clamp(1.0, 255.0) as u32;
        self.if_there(0x60c2, 1, |_| (period_ms, 1))?;
        self.set(0x1017, 0, (HEARTBEAT_MS, 2))?;
        let patience = (1e3 * machine.watchdog()).ceil() as u32;
        self.set(0x1016, 1, (u32::from(MASTER) << 16 | patience, 4))
    }

    /// A PDO that goes with SYNC: off, mapped, on.
    fn pdo(&mut self, index: u16, function: u16, mapping: &[u32]) -> Result<(), CanError> {
        let id = u32::from(function) + u32::from(self.device.node);
        self.set(index, 1, (id | INVALID, 4))?;
        self.set(index, 2, (1, 1))?;
        self.set(index + 0x200, 0, (0, 1))?;
        for (subindex, entry) in (1..).zip(mapping) {
            self.set(index + 0x200, subindex, (*entry, 4))?;
        }
        self.set(index + 0x200, 0, (mapping.len() as u32, 1))?;
        self.set(index, 1, (id, 4))
    }

    /// Writes a value of some octets where another one stands, and reads it back.
    fn set(&mut self, index: u16, subindex: u8, (value, octets): (u32, usize)) -> Result<(), CanError> {
        if self.read(index, subindex)? == value {
            return Ok(());
        }
        let data = value.to_le_bytes();
        let written = self.client.write(self.device.node, (index, subindex), &data[..octets]);
        written.map_err(|error| self.refused((index, subindex), value, error))?;
        let got = self.read(index, subindex)?;
        if got == value {
            return Ok(());
        }
        let (device, reason) = (self.device.name.clone(), format!("reads back as {got:#x}"));
        Err(CanError::Refused { device, index, subindex, value, reason })
    }

    /// The same of an object that a node need not have: its new value from the present one.
    fn if_there(
        &mut self,
        index: u16,
        subindex: u8,
        value: impl Fn(u32) -> (u32, usize),
    ) -> Result<(), CanError> {
        match self.client.number(self.device.node, (index, subindex)) {
            Ok(present) => self.set(index, subindex, value(present)),
            Err(error) if error.is_missing() => Ok(()),
            Err(error) => Err(self.refused((index, subindex), 0, error)),
        }
    }

    fn read(&mut self, index: u16, subindex: u8) -> Result<u32, CanError> {
        let number = self.client.number(self.device.node, (index, subindex));
        number.map_err(|error| self.refused((index, subindex), 0, error))
    }

    fn refused(&self, (index, subindex): (u16, u8), value: u32, error: SdoError) -> CanError {
        let CanDevice { name, node, bitrate, .. } = self.device;
        match error {
            SdoError::Port(source) => self.device.unusable(source),
            SdoError::Silent => CanError::Silent { device: name.clone(), node: *node, bitrate: *bitrate },
            SdoError::Abort(_) | SdoError::Damaged => {
                CanError::Refused { device: name.clone(), index, subindex, value, reason: error.to_string() }
            }
        }
    }
}
