//! A simulated segment in the process: virtual time, the machine's twin behind the devices.

use super::link::Link;
use super::pump::MAX_FRAME;
use super::simulated_machine::SimulatedMachine;
use sinew_segment::{Passed, Segment};
use sinew_session::BusFault;
use std::io;

/// Frames that go through a simulated segment, whose drives and sensors are those of a simulated machine.
///
/// Frames come back after the delay of the line. The machine advances by one period before every cycle, from
/// when the first of its brakes is released.
#[derive(Debug, Clone)]
pub struct SegmentLink {
    segment: Segment,
    machine: SimulatedMachine,
    /// Frames that are under way, with the times when they are back, ns.
    under_way: Vec<(u64, usize, [u8; MAX_FRAME])>,
    /// Number of frames in it.
    count: usize,
    /// When the cycle began, and when the next one is to begin where that was said, ns.
    begin: u64,
    next: Option<u64>,
    /// What is wrong with the exchange by injection, and cycles for which no command has come.
    injected: Option<BusFault>,
    stale_for: u32,
}

/// Frames under way, at most; more are lost.
const CAPACITY: usize = 16;
/// Time for the firmware of the devices to show new measurements, ns.
const SHOWING: u64 = 1000;
/// Time that passes while nothing is under way, ns.
const IDLE: u64 = 10_000;

impl SegmentLink {
    /// A segment whose devices are those of the machine's fieldbus, in their order.
    #[must_use]
    pub fn new(segment: Segment, machine: SimulatedMachine) -> Self {
        let under_way = vec![(0, 0, [0; MAX_FRAME]); CAPACITY];
        Self { segment, machine, under_way, count: 0, begin: 0, next: None, injected: None, stale_for: 0 }
    }

    /// The devices.
    #[must_use]
    pub fn segment(&self) -> &Segment {
        &self.segment
    }

    /// The devices, to let them fail.
    pub fn segment_mut(&mut self) -> &mut Segment {
        &mut self.segment
    }

    /// The machine behind the devices.
    #[must_use]
    pub fn machine(&self) -> &SimulatedMachine {
        &self.machine
    }
}

impl Link for SegmentLink {
    fn now(&mut self) -> u64 {
        self.segment.now()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        if self.injected == Some(BusFault::Lost) {
            return Ok(());
        }
        let Some((due, length, buffer)) = self.under_way.get_mut(self.count) else { return Ok(()) };
        let Some(copy) = buffer.get_mut(..frame.len()) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "a frame above 1514 octets"));
        };
        copy.copy_from_slice(frame);
        if let Passed::Returned { delay_ns } = self.segment.process(copy) {
            (*due, *length) = (self.segment.now() + delay_ns, frame.len());
            self.count += 1;
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        let now = self.segment.now();
        let Some(first) = self.under_way[..self.count].iter().position(|(due, ..)| *due <= now) else {
            return Ok(None);
        };
        let (_, length, frame) = &self.under_way[first];
        let length = *length;
        buffer[..length].copy_from_slice(&frame[..length]);
        self.count -= 1;
        self.under_way.swap(first, self.count);
        Ok(Some(length))
    }

    fn idle(&mut self) {
        let now = self.segment.now();
        let next = self.under_way[..self.count].iter().map(|(due, ..)| due.saturating_sub(now)).min();
        self.segment.advance(next.unwrap_or(IDLE).max(1));
    }

    fn rest_until(&mut self, time: u64) {
        self.next = Some(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        let now = self.segment.now();
        self.begin = self.next.take().unwrap_or(self.begin + period).max(now);
        let left = self.begin - now;
        let failure = self.machine.arm().exchange_failure();
        self.injected = BusFault::injected(failure, &mut self.stale_for, period as f64 * 1e-9);
        // The firmware takes over the outputs, the machine moves, the firmware shows the measurements.
        self.segment.advance(left.saturating_sub(SHOWING));
        self.machine.advance(&mut self.segment, period);
        self.segment.advance(left.min(SHOWING));
    }

    fn injected(&self) -> Option<BusFault> {
        self.injected
    }

    fn simulated(&self) -> Option<&SimulatedMachine> {
        Some(&self.machine)
    }
}
