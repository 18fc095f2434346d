use crate::Error;
use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::{Timespec, clock_gettime};

/// Time of the control cycle, ns.
pub trait Clock {
    /// Since a fixed moment, ns.
    fn now(&mut self) -> u64;

    /// Returns at the deadline, ns, or at once where it has passed.
    ///
    /// # Errors
    /// [`Error::Clock`] where the operating system refuses to wait.
    fn wait_until(&mut self, deadline: u64) -> Result<(), Error>;
}

/// The system's monotonic clock; waits for absolute deadlines, so that delays do not add up.
#[derive(Debug, Clone, Copy, Default)]
pub struct MonotonicClock;

impl Clock for MonotonicClock {
    fn now(&mut self) -> u64 {
        let time = clock_gettime(ClockId::Monotonic);
        time.tv_sec.unsigned_abs() * NANOSECONDS + time.tv_nsec.unsigned_abs()
    }

    fn wait_until(&mut self, deadline: u64) -> Result<(), Error> {
        let until = Timespec {
            tv_sec: (deadline / NANOSECONDS).cast_signed(),
            tv_nsec: (deadline % NANOSECONDS).cast_signed(),
        };
        loop {
            match clock_nanosleep_absolute(ClockId::Monotonic, &until) {
                Ok(()) => return Ok(()),
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(Error::Clock(error.into())),
            }
        }
    }
}

/// 1 s, ns.
const NANOSECONDS: u64 = 1_000_000_000;

/// A clock that is at every deadline at once.
#[derive(Debug, Clone, Copy, Default)]
pub struct VirtualClock {
    now: u64,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> u64 {
        self.now
    }

    fn wait_until(&mut self, deadline: u64) -> Result<(), Error> {
        self.now = self.now.max(deadline);
        Ok(())
    }
}
