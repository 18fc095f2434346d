//! What is said to one node before it takes commands.

use super::Link;
use super::device::CanDevice;
use super::error::{CanError, TWO_ANSWER};
use sinew_segment::CanFrame as Frame;

/// Time for an answer, and in which a second node of the same identifier has answered, ns.
const PATIENCE: u64 = 100_000_000;
const TWICE: u64 = 5_000_000;
/// Times that something is asked for.
const TRIES: usize = 3;
/// Time in which a node takes a state, ns.
pub(super) const STATE_TIME: u64 = 1_000_000_000;
/// Silence after which a watchdog has to have acted, of the time that it may have.
pub(super) const SILENCE: f64 = 1.5;

/// A node that is being set up.
pub(super) struct Talk<'a, L> {
    pub(super) link: &'a mut L,
    pub(super) device: &'a CanDevice,
    /// Control period, ns.
    pub(super) period: u64,
}

impl<L: Link> Talk<'_, L> {
    pub(super) fn send(&mut self, frames: &[Frame]) -> Result<(), CanError> {
        self.link.send(frames).map_err(|source| self.device.unusable(source))
    }

    /// What is seen in the next frame in which something is, until a deadline, ns.
    pub(super) fn next<T>(
        &mut self,
        deadline: u64,
        see: impl Fn(&Frame) -> Option<T>,
    ) -> Result<Option<T>, CanError> {
        while let Some(frame) = self.link.receive(deadline).map_err(|source| self.device.unusable(source))? {
            if let Some(seen) = see(&frame) {
                return Ok(Some(seen));
            }
        }
        Ok(None)
    }

    /// What is seen in an answer, where one comes; asked for three times.
    pub(super) fn try_answer<T>(
        &mut self,
        ask: &Frame,
        see: impl Fn(&Frame) -> Option<T>,
    ) -> Result<Option<T>, CanError> {
        for _ in 0..TRIES {
            self.send(&[*ask])?;
            let deadline = self.link.now() + PATIENCE;
            if let Some(seen) = self.next(deadline, &see)? {
                return Ok(Some(seen));
            }
        }
        Ok(None)
    }

    /// As [`try_answer`](Self::try_answer); without one the node is missing.
    pub(super) fn answer<T>(
        &mut self,
        ask: &Frame,
        see: impl Fn(&Frame) -> Option<T>,
    ) -> Result<T, CanError> {
        let CanDevice { name, node, bitrate, .. } = self.device;
        self.try_answer(ask, see)?.ok_or_else(|| CanError::Silent {
            device: name.clone(),
            node: *node,
            bitrate: *bitrate,
        })
    }

    /// Refuses a second answer, which a second node of the same identifier gives.
    pub(super) fn is_alone<T>(&mut self, see: impl Fn(&Frame) -> Option<T>) -> Result<(), CanError> {
        let deadline = self.link.now() + TWICE;
        if self.next(deadline, see)?.is_some() { Err(self.device.wrong(TWO_ANSWER)) } else { Ok(()) }
    }

    /// Time passes, ns.
    pub(super) fn pass(&mut self, time: u64) {
        let end = self.link.now() + time;
        while self.link.now() < end {
            let next = (self.link.now() + self.period).min(end);
            self.link.rest_until(next);
            self.link.begin_cycle(self.period);
        }
    }
}
