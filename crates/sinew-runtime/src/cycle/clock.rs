use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::{Timespec, clock_gettime};
use sinew_session::Clock;
use std::io;

/// The system's monotonic clock; waits for absolute deadlines, so that delays do not add up.
#[derive(Debug, Clone, Copy, Default)]
pub struct MonotonicClock;

/// 1 s, ns.
const NANOSECONDS: u64 = 1_000_000_000;

impl Clock for MonotonicClock {
    fn now(&mut self) -> u64 {
        let time = clock_gettime(ClockId::Monotonic);
        time.tv_sec.unsigned_abs() * NANOSECONDS + time.tv_nsec.unsigned_abs()
    }

    fn wait_until(&mut self, deadline: u64) -> io::Result<()> {
        let until = Timespec {
            tv_sec: (deadline / NANOSECONDS).cast_signed(),
            tv_nsec: (deadline % NANOSECONDS).cast_signed(),
        };
        loop {
            match clock_nanosleep_absolute(ClockId::Monotonic, &until) {
                Ok(()) => return Ok(()),
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}
