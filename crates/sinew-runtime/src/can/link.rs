//! What carries frames to the nodes and back.

use super::SimulatedMachine;
use super::sign::Sign;
use sinew_segment::CanFrame as Frame;
use sinew_session::BusFault;
use std::io;

/// A bus with nodes.
pub trait Link {
    /// Whether it has frames of CAN FD.
    fn carries_fd(&self) -> bool {
        false
    }

    /// Time, ns: of the system's monotonic clock, or virtual.
    fn now(&mut self) -> u64;

    /// Sends frames, one after the other.
    ///
    /// # Errors
    /// Of the operating system, where the adapter is gone.
    fn send(&mut self, frames: &[Frame]) -> io::Result<()>;

    /// The next frame that has come, after waiting for one until a deadline, ns; none where none came.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>>;

    /// Outside of a control cycle: returns at a time, ns.
    fn rest_until(&mut self, time: u64);

    /// A cycle begins: where time is virtual, the rest of the last one's period, ns, passes.
    fn begin_cycle(&mut self, period: u64);

    /// Starts a watchdog that does not depend on this program: it sends frames by itself where no sign of
    /// life comes for a time, ns.
    ///
    /// # Errors
    /// Of the operating system; the link has none.
    fn guard(&mut self, _leave: &[Frame], _time: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// A sign of life to the watchdog.
    ///
    /// # Errors
    /// It has ended, as after it has acted, or does not read.
    fn sign(&mut self, _sign: Sign) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Of a simulated machine: what is wrong by injection in the cycle that has begun.
    fn injected(&self) -> Option<BusFault> {
        None
    }

    /// The simulated machine behind the nodes; none behind real ones.
    fn simulated(&self) -> Option<&SimulatedMachine> {
        None
    }
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn carries_fd(&self) -> bool {
        (**self).carries_fd()
    }

    fn now(&mut self) -> u64 {
        (**self).now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        (**self).send(frames)
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        (**self).receive(deadline)
    }

    fn rest_until(&mut self, time: u64) {
        (**self).rest_until(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        (**self).begin_cycle(period);
    }

    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        (**self).guard(leave, time)
    }

    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        (**self).sign(sign)
    }

    fn injected(&self) -> Option<BusFault> {
        (**self).injected()
    }

    fn simulated(&self) -> Option<&SimulatedMachine> {
        (**self).simulated()
    }
}
