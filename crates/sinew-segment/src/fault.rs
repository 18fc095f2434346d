//! Faults of a line that can be injected at a point of virtual time.

use crate::al::AlStatusCode;
use crate::device::Device;

/// A fault of one device, from a start for a duration.
#[derive(Debug, Clone)]
pub struct Fault {
    /// Position of the device on the line, from 0.
    pub device: usize,
    /// What happens.
    pub kind: FaultKind,
    /// Virtual time at which it begins, ns.
    pub start_ns: u64,
    /// How long it lasts, ns; none is indefinitely. What happens once ignores it.
    pub duration_ns: Option<u64>,
}

/// What happens to a device or to the frames that pass it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum FaultKind {
    /// Once: the device falls to SAFE-OP with this code.
    DropToSafeOp(AlStatusCode),
    /// Once: an emergency with error code, error register and five octets.
    Emergency(u16, u8, [u8; 5]),
    /// Once: the drive detects a fault with this error code.
    DriveFault(u16),
    /// Every datagram's working counter is changed by this much.
    WorkingCounter(i16),
    /// Frames pass without being processed.
    Mute,
    /// The cable in front of the device is open: frames return before it. The device runs on and, at the end,
    /// is back as it is then.
    OffTheWire,
    /// The device has no power: frames return before it. At the end it starts anew, in INIT.
    PowerLoss,
    /// Frames come back this much later, ns.
    Late(u64),
    /// Frames are damaged at the device: those behind it and the master see a wrong checksum.
    Corrupted,
    /// Frames do not come back.
    Lost,
    /// Another device stands in its place; at the end the first one is back, started anew.
    Swapped(Box<Device>),
}

/// A fault at a position at which there is no device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a fault of device {device}, expected less than {devices}")]
pub struct NoSuchDevice {
    /// The position.
    pub device: usize,
    /// Number of devices.
    pub devices: usize,
}

/// What all present faults together do to the frames at one device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Disturbance {
    pub(crate) off: bool,
    pub(crate) mute: bool,
    pub(crate) corrupted: bool,
    pub(crate) lost: bool,
    pub(crate) late_ns: u64,
    pub(crate) counter: i16,
}

impl Disturbance {
    pub(crate) fn add(&mut self, kind: &FaultKind) {
        match kind {
            FaultKind::WorkingCounter(by) => self.counter = self.counter.wrapping_add(*by),
            FaultKind::Mute => self.mute = true,
            FaultKind::OffTheWire | FaultKind::PowerLoss => self.off = true,
            FaultKind::Late(by) => self.late_ns = self.late_ns.saturating_add(*by),
            FaultKind::Corrupted => self.corrupted = true,
            FaultKind::Lost => self.lost = true,
            FaultKind::DropToSafeOp(_)
            | FaultKind::Emergency(..)
            | FaultKind::DriveFault(_)
            | FaultKind::Swapped(_) => {}
        }
    }
}

/// A fault and whether it has begun.
#[derive(Debug, Clone)]
pub(crate) struct Scheduled {
    pub(crate) fault: Fault,
    pub(crate) begun: bool,
    pub(crate) ended: bool,
}

impl Scheduled {
    pub(crate) fn new(fault: Fault) -> Self {
        Self { fault, begun: false, ended: false }
    }

    fn end(&self) -> Option<u64> {
        self.fault.duration_ns.and_then(|duration| self.fault.start_ns.checked_add(duration))
    }

    /// The next time after `now` at which something changes.
    pub(crate) fn boundary(&self, now: u64) -> Option<u64> {
        [Some(self.fault.start_ns), self.end()].into_iter().flatten().find(|time| *time > now)
    }

    /// Does what happens at the beginning and at the end; whether the fault is present.
    pub(crate) fn follow(&mut self, now: u64, device: &mut Device) -> bool {
        if !self.begun && now >= self.fault.start_ns {
            self.begun = true;
            match &mut self.fault.kind {
                FaultKind::DropToSafeOp(code) => device.drop_to_safe_op(*code),
                FaultKind::Emergency(code, register, data) => device.send_emergency(*code, *register, *data),
                FaultKind::DriveFault(code) => {
                    if let Some(drive) = device.drive_mut() {
                        drive.raise_fault(*code);
                    }
                }
                FaultKind::Swapped(other) => core::mem::swap(device, other),
                _ => {}
            }
        }
        if self.begun && !self.ended && self.end().is_some_and(|end| now >= end) {
            self.ended = true;
            match &mut self.fault.kind {
                FaultKind::PowerLoss => device.power_cycle(),
                FaultKind::Swapped(other) => {
                    core::mem::swap(device, other);
                    device.power_cycle();
                }
                _ => {}
            }
        }
        self.begun && !self.ended
    }
}
