use std::io;

/// Time of the control cycle, ns.
pub trait Clock {
    /// Since a fixed moment, ns.
    fn now(&mut self) -> u64;

    /// Returns at the deadline, ns, or at once where it has passed.
    ///
    /// # Errors
    /// Where the operating system refuses to wait.
    fn wait_until(&mut self, deadline: u64) -> io::Result<()>;
}

/// A clock that is at every deadline at once.
#[derive(Debug, Clone, Copy, Default)]
pub struct VirtualClock {
    now: u64,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> u64 {
        self.now
    }

    fn wait_until(&mut self, deadline: u64) -> io::Result<()> {
        self.now = self.now.max(deadline);
        Ok(())
    }
}
