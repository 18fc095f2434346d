//! The line: devices in the order in which a frame passes them.

use crate::device::Device;
use crate::esc::register;
use crate::fault::{Disturbance, Fault, NoSuchDevice, Scheduled};
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
    /// An EtherCAT frame whose lengths do not fit: it comes back, as far as it was processed before the
    /// error.
    Malformed,
    /// It comes back with a wrong checksum, which a network card drops.
    Corrupted,
    /// It does not come back.
    Lost,
}

/// A chain of devices in virtual time.
#[derive(Debug, Clone, Default)]
pub struct Segment {
    devices: Vec<Device>,
    now: u64,
    faults: Vec<Scheduled>,
    /// Of each device, where there are faults at all.
    disturbances: Vec<Disturbance>,
}

impl Segment {
    /// Devices in the order on the wire.
    #[must_use]
    pub fn new(devices: Vec<Device>) -> Self {
        let disturbances = vec![Disturbance::default(); devices.len()];
        let mut segment = Self { devices, now: 0, faults: Vec::new(), disturbances };
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

    /// Injects a fault. One that has already begun takes effect at once.
    ///
    /// # Errors
    ///
    /// There is no device at the position.
    pub fn inject(&mut self, fault: Fault) -> Result<(), NoSuchDevice> {
        if fault.device >= self.devices.len() {
            return Err(NoSuchDevice { device: fault.device, devices: self.devices.len() });
        }
        self.faults.push(Scheduled::new(fault));
        self.follow_faults();
        Ok(())
    }

    /// Ends all faults that disturb frames and forgets those to come; swapped devices stay swapped.
    pub fn clear_faults(&mut self) {
        self.faults.clear();
        self.follow_faults();
    }

    /// Virtual time passes: the firmware of every device runs once, at its end. Faults begin and end at their
    /// time, before the firmware runs.
    pub fn advance(&mut self, nanoseconds: u64) {
        let end = self.now.saturating_add(nanoseconds);
        loop {
            let boundary = self.faults.iter().filter_map(|fault| fault.boundary(self.now)).min();
            let next = boundary.filter(|boundary| *boundary < end).unwrap_or(end);
            let elapsed = next - self.now;
            self.now = next;
            for device in &mut self.devices {
                device.pass_time(elapsed);
            }
            if !self.faults.is_empty() {
                self.follow_faults();
            }
            for device in &mut self.devices {
                device.run(elapsed);
            }
            if next == end {
                break;
            }
        }
    }

    fn follow_faults(&mut self) {
        self.disturbances.fill(Disturbance::default());
        for scheduled in &mut self.faults {
            let at = scheduled.fault.device;
            if scheduled.follow(self.now, &mut self.devices[at]) {
                self.disturbances[at].add(&scheduled.fault.kind);
            }
        }
        self.faults.retain(|scheduled| !scheduled.ended);
        self.set_links();
    }

    /// One whole Ethernet frame, without checksum, passes all devices and comes back.
    pub fn process(&mut self, frame: &mut [u8]) -> Passed {
        let range = match payload(frame) {
            Payload::Datagrams(range) => range,
            Payload::Other => return Passed::Ignored,
            Payload::Short => return self.malformed(),
        };
        let reached = self.reached();
        if reached == 0 {
            return Passed::Lost;
        }
        let delay_ns = self.announce(reached);
        if let Some(octet) = frame.get_mut(6) {
            *octet |= PASSED;
        }
        let intact = self.disturbances[..reached].iter().position(|disturbance| disturbance.corrupted);
        let complete =
            self.answer(frame.get_mut(range.clone()).unwrap_or_default(), intact.unwrap_or(reached));
        for device in &mut self.devices[..reached] {
            device.after_frame();
        }
        if let Some(first) = intact {
            self.damage(frame, range.start, first, reached);
            return Passed::Corrupted;
        }
        if self.disturbances[..reached].iter().any(|disturbance| disturbance.lost) {
            return Passed::Lost;
        }
        if complete { Passed::Returned { delay_ns } } else { self.malformed() }
    }

    /// Every datagram passes the first `count` devices; false where lengths do not fit.
    fn answer(&mut self, mut rest: &mut [u8], count: usize) -> bool {
        loop {
            let Some((mut datagram, behind, more)) = Datagram::split(rest) else { return false };
            for (device, disturbance) in self.devices[..count].iter_mut().zip(&self.disturbances) {
                if !disturbance.mute {
                    device.answer(&mut datagram);
                }
                datagram.counter = datagram.counter.wrapping_add_signed(disturbance.counter);
            }
            datagram.finish();
            if !more {
                return true;
            }
            rest = behind;
        }
    }

    /// Flips bits, and counts the wrong checksum at the devices behind and on the way back.
    fn damage(&mut self, frame: &mut [u8], start: usize, first: usize, reached: usize) {
        if let Some(octet) = frame.get_mut(start) {
            *octet ^= 0x55;
        }
        for (at, device) in self.devices[..reached].iter_mut().enumerate() {
            let (port0, port1) = (register::RX_ERRORS, register::RX_ERRORS + 2);
            if at > first {
                device.controller().count_error(port0);
            }
            if at + 1 < reached {
                device.controller().count_error(port1);
            }
        }
    }

    /// Devices that a frame reaches: up to one whose master has closed its second port, or an open cable.
    fn reached(&self) -> usize {
        let closing =
            self.devices.iter().position(Device::closes_line).map_or(self.devices.len(), |at| at + 1);
        let open =
            self.disturbances.iter().position(|disturbance| disturbance.off).unwrap_or(self.devices.len());
        closing.min(open)
    }

    /// Tells every device when the frame comes to its ports; returns when it is back at the master.
    fn announce(&mut self, reached: usize) -> u64 {
        let devices = &mut self.devices[..reached];
        let line: u64 = devices.iter().map(|device| device.forward_delay_ns).sum();
        let (mut there, mut late) = (0, 0_u64);
        for (device, disturbance) in devices.iter_mut().zip(&self.disturbances) {
            there += device.forward_delay_ns;
            // Back at port 1 after all devices behind, forth and back.
            let back = there + 2 * (line - there);
            device.controller().frame(there, back);
            late = late.saturating_add(disturbance.late_ns);
        }
        late.saturating_add(2 * line)
    }

    fn malformed(&mut self) -> Passed {
        let reached = self.reached();
        for device in &mut self.devices[..reached] {
            device.controller().count_error(register::PROCESSING_ERRORS);
        }
        if reached == 0 { Passed::Lost } else { Passed::Malformed }
    }

    fn set_links(&mut self) {
        for at in 0..self.devices.len() {
            let off = |at: usize| self.disturbances.get(at).is_none_or(|disturbance| disturbance.off);
            let (before, behind) = (!off(at), !off(at + 1));
            self.devices[at].controller().set_links(before, behind);
        }
    }
}
