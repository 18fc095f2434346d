//! Simulated drives on CAN. Whoever drives them lets time pass and carries their frames.

mod canopen;
mod cansimple;
mod frame;
mod mit;
mod mit_frame;
mod moteus;

use crate::drive::Drive;
use canopen::Canopen;

pub use cansimple::Cansimple;
pub use frame::CanFrame;
pub use mit::Mit;
pub use mit_frame::{MitCommand, MitFamily, MitRanges, MitReadings};
pub use moteus::Moteus;

/// How a simulated node fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CanFault {
    /// It hears and says nothing, as with its plug pulled.
    Silent,
    /// Of this many of its frames one does not arrive.
    Loses(u32),
    /// It sends no heartbeat.
    NoHeartbeat,
}

/// A simulated drive with its place on the bus.
#[derive(Debug, Clone)]
pub struct CanNode {
    speaks: Speaks,
    sent: u32,
    fault: Option<CanFault>,
}

#[derive(Debug, Clone)]
enum Speaks {
    Canopen(Box<Canopen>),
    Cansimple(Cansimple),
    Moteus(Moteus),
    Mit(Mit),
}

/// The drive in a node, by its protocol.
#[derive(Debug)]
pub enum CanDrive<'a> {
    /// CANopen, CiA 402.
    Canopen(&'a mut Drive),
    /// CANSimple.
    Cansimple(&'a mut Cansimple),
    /// moteus.
    Moteus(&'a mut Moteus),
    /// MIT mode.
    Mit(&'a mut Mit),
}

impl CanNode {
    /// A node on CANopen that has started, with this identifier of 1 to 127 and the vendor ID and product
    /// code that its master expects, or those of the built-in drive.
    #[must_use]
    pub fn canopen(id: u8, identity: [Option<u32>; 2]) -> Self {
        Self::of(Speaks::Canopen(Box::new(Canopen::new(id, identity))))
    }

    /// A node on CANSimple that has started, with this identifier of 0 to 62, which loses its power after a
    /// time without commands, ns, 0 for never.
    #[must_use]
    pub fn cansimple(id: u8, watchdog: u64) -> Self {
        Self::of(Speaks::Cansimple(Cansimple::new(id, watchdog)))
    }

    /// A moteus controller that has started, with this identifier of 1 to 126.
    #[must_use]
    pub fn moteus(id: u8) -> Self {
        Self::of(Speaks::Moteus(Moteus::new(id)))
    }

    /// A motor in MIT mode that has started, with this identifier of 1 to 126, of a DAMIAO up to 15.
    #[must_use]
    pub fn mit(id: u8, ranges: MitRanges) -> Self {
        Self::of(Speaks::Mit(Mit::new(id, ranges)))
    }

    fn of(speaks: Speaks) -> Self {
        Self { speaks, sent: 0, fault: None }
    }

    /// The drive in it.
    pub fn drive_mut(&mut self) -> CanDrive<'_> {
        match &mut self.speaks {
            Speaks::Canopen(node) => CanDrive::Canopen(node.drive_mut()),
            Speaks::Cansimple(node) => CanDrive::Cansimple(node),
            Speaks::Moteus(node) => CanDrive::Moteus(node),
            Speaks::Mit(node) => CanDrive::Mit(node),
        }
    }

    /// Whether its motor has power.
    #[must_use]
    pub fn has_power(&self) -> bool {
        match &self.speaks {
            Speaks::Canopen(node) => node.drive().brake_released(),
            Speaks::Cansimple(node) => node.is_armed(),
            Speaks::Moteus(node) => node.has_power(),
            Speaks::Mit(node) => node.has_power(),
        }
    }

    /// Error code of the present or last fault of a drive on CANopen, error bits of one on CANSimple, fault
    /// code of a moteus, or 11 where it has timed out, error of a motor in MIT mode; 0 is none.
    #[must_use]
    pub fn error(&self) -> u32 {
        match &self.speaks {
            Speaks::Canopen(node) => u32::from(node.drive().error_code()),
            Speaks::Cansimple(node) => node.errors(),
            Speaks::Moteus(node) => node.error(),
            Speaks::Mit(node) => node.error(),
        }
    }

    /// Its drive detects a fault, as [`error`](Self::error).
    pub fn raise_fault(&mut self, error: u32) {
        match self.drive_mut() {
            CanDrive::Canopen(drive) => drive.raise_fault(error as u16),
            CanDrive::Cansimple(node) => node.raise_fault(error),
            CanDrive::Moteus(node) => node.raise_fault(error as u8),
            CanDrive::Mit(node) => node.raise_fault(error as u8),
        }
    }

    /// Lets it fail, or ends that.
    pub fn set_fault(&mut self, fault: Option<CanFault>) {
        self.fault = fault;
    }

    /// Starts anew, as when its power was gone for a moment.
    pub fn restart(&mut self) {
        match &mut self.speaks {
            Speaks::Canopen(node) => node.restart(),
            Speaks::Cansimple(node) => node.restart(),
            Speaks::Moteus(node) => node.restart(),
            Speaks::Mit(node) => node.restart(),
        }
    }

    /// A frame of another node comes at a time, ns; what it answers is appended to `out`.
    pub fn process(&mut self, frame: &CanFrame, now: u64, out: &mut Vec<CanFrame>) {
        if self.fault == Some(CanFault::Silent) {
            return;
        }
        let start = out.len();
        match &mut self.speaks {
            Speaks::Canopen(node) => node.process(frame, now, out),
            Speaks::Cansimple(node) => node.process(frame, now, out),
            Speaks::Moteus(node) => node.process(frame, now, out),
            Speaks::Mit(node) => node.process(frame, now, out),
        }
        self.lose(start, out);
    }

    /// Time passes: `elapsed` ns that end at `now`; what the node sends by itself is appended to `out`.
    pub fn advance(&mut self, now: u64, elapsed: u64, out: &mut Vec<CanFrame>) {
        let (start, beats) = (out.len(), self.fault != Some(CanFault::NoHeartbeat));
        match &mut self.speaks {
            Speaks::Canopen(node) => node.advance(now, elapsed, beats, out),
            Speaks::Cansimple(node) => node.advance(now, beats, out),
            Speaks::Moteus(node) => node.advance(now, elapsed),
            Speaks::Mit(node) => node.advance(now),
        }
        self.lose(start, out);
    }

    /// What its fault takes away of what it sends.
    fn lose(&mut self, start: usize, out: &mut Vec<CanFrame>) {
        match self.fault {
            Some(CanFault::Silent) => out.truncate(start),
            Some(CanFault::Loses(of)) if out.len() > start => {
                self.sent = self.sent.wrapping_add(1);
                if self.sent.is_multiple_of(of.max(1)) {
                    out.pop();
                }
            }
            _ => {}
        }
    }
}
