//! The line: devices in the order in which a frame passes them.

use crate::device::Device;
use crate::esc::register;
use crate::frame::{Datagram, Payload, payload};

/// The bit of the source address that the first device sets: locally administered.
const PASSED: u8 = 0x02;

/// The fate of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Passed {
    /// It comes back, processed, after the delay of the line.
    Returned {
        /// Delay, ns.
        delay_ns: u64,
    },
    /// Not EtherCAT; devices destroy such frames.
    Ignored,
    /// An EtherCAT frame whose lengths do not fit: it comes back, as far as it was processed before the error.
    Malformed,
}

/// A chain of devices in virtual time.
#[derive(Debug, Clone, Default)]
pub struct Segment {
    devices: Vec<Device>,
    now: u64,
}

impl Segment {
    /// Devices in the order on the wire.
    #[must_use]
    pub fn new(devices: Vec<Device>) -> Self {
        let mut segment = Self { devices, now: 0 };
        segment.set_links();
        segment
    }

    /// Virtual time since the start, ns.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Devices in the order on the wire.
    #[must_use]
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// A device by its position, from 0.
    #[must_use]
    pub fn device(&self, position: usize) -> Option<&Device> {
        self.devices.get(position)
    }

    /// A device by its position, from 0.
    pub fn device_mut(&mut self, position: usize) -> Option<&mut Device> {
        self.devices.get_mut(position)
    }

    /// Virtual time passes: the firmware of every device runs once, at its end.
    pub fn advance(&mut self, nanoseconds: u64) {
        self.now = self.now.saturating_add(nanoseconds);
        for device in &mut self.devices {
            device.advance(nanoseconds);
        }
    }

    /// One whole Ethernet frame, without checksum, passes all devices and comes back.
    pub fn process(&mut self, frame: &mut [u8]) -> Passed {
        let range = match payload(frame) {
            Payload::Datagrams(range) => range,
            Payload::Other => return Passed::Ignored,
            Payload::Short => return self.malformed(),
        };
        let reached = self.reached();
        let delay_ns = self.announce(reached);
        if let Some(octet) = frame.get_mut(6).filter(|_| reached > 0) {
            *octet |= PASSED;
        }
        let mut rest = frame.get_mut(range).unwrap_or_default();
        let mut complete = true;
        loop {
            let Some((mut datagram, behind, more)) = Datagram::split(rest) else {
                complete = false;
                break;
            };
            for device in &mut self.devices[..reached] {
                device.answer(&mut datagram);
            }
            datagram.finish();
            if !more {
                break;
            }
            rest = behind;
        }
        for device in &mut self.devices[..reached] {
            device.after_frame();
        }
        if complete { Passed::Returned { delay_ns } } else { self.malformed() }
    }

    /// Devices that a frame reaches: up to one whose master has closed its second port.
    fn reached(&mut self) -> usize {
        let closing = self.devices.iter().position(Device::closes_line);
        closing.map_or(self.devices.len(), |at| at + 1)
    }

    /// Tells every device when the frame comes to its ports; returns when it is back at the master.
    fn announce(&mut self, reached: usize) -> u64 {
        let devices = &mut self.devices[..reached];
        let line: u64 = devices.iter().map(|device| device.forward_delay_ns).sum();
        let mut there = 0;
        for device in devices {
            there += device.forward_delay_ns;
            // Back at port 1 after all devices behind, forth and back.
            let back = there + 2 * (line - there);
            device.controller().frame(there, back);
        }
        2 * line
    }

    fn malformed(&mut self) -> Passed {
        for device in &mut self.devices {
            device.controller().count_error(register::PROCESSING_ERRORS);
        }
        Passed::Malformed
    }

    fn set_links(&mut self) {
        let count = self.devices.len();
        for (at, device) in self.devices.iter_mut().enumerate() {
            device.controller().set_links(true, at + 1 < count);
        }
    }
}
