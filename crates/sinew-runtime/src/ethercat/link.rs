use super::simulated_machine::SimulatedMachine;
use sinew_session::BusFault;
use std::io;

/// What carries Ethernet frames to the devices and back.
pub trait Link {
    /// Time, ns: of the system's monotonic clock, or virtual.
    fn now(&mut self) -> u64;

    /// Sends one frame, without checksum.
    ///
    /// # Errors
    /// Of the operating system, where the interface is down or gone.
    fn send(&mut self, frame: &[u8]) -> io::Result<()>;

    /// The length of a frame that has come back and is now in `buffer`; none where there is none yet.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>>;

    /// Lets a little time pass while nothing comes back.
    fn idle(&mut self);

    /// Outside of a control cycle: returns at a time, ns; at once where time is virtual, whose next cycle
    /// then begins there.
    fn rest_until(&mut self, time: u64);

    /// A cycle begins: where time is virtual, the rest of the last one's period, ns, passes.
    fn begin_cycle(&mut self, period: u64);

    /// Of a simulated machine: what is wrong by injection in the cycle that has begun; of a lost exchange no
    /// frame comes back.
    fn injected(&self) -> Option<BusFault> {
        None
    }

    /// The simulated machine behind the devices; none behind real ones.
    fn simulated(&self) -> Option<&SimulatedMachine> {
        None
    }
}
