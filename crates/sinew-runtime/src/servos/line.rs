//! What carries octets to the servos and back.

use super::simulated::SimulatedMachine;
use sinew_session::BusFault;
use std::io;

/// Lines with servos, by their number.
pub trait Lines {
    /// How many there are.
    fn count(&self) -> usize;

    /// Time, ns: of the system's monotonic clock, or virtual.
    fn now(&mut self) -> u64;

    /// Sends octets.
    ///
    /// # Errors
    /// Of the operating system, where the adapter is gone.
    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()>;

    /// How many octets have come and are now in `buffer`, after waiting for some until a deadline, ns; 0
    /// where none came.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize>;

    /// Outside of a control cycle: returns at a time, ns.
    fn rest_until(&mut self, time: u64);

    /// A cycle begins: where time is virtual, the rest of the last one's period, ns, passes.
    fn begin_cycle(&mut self, period: u64);

    /// Of a simulated machine: what is wrong by injection in the cycle that has begun.
    fn injected(&self) -> Option<BusFault> {
        None
    }

    /// The simulated machine behind the servos; none behind real ones.
    fn simulated(&self) -> Option<&SimulatedMachine> {
        None
    }
}
