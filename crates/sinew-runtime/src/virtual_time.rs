//! Virtual time in front of a simulated machine: it moves on by a period with every cycle.

use sinew_session::BusFault;

/// A machine behind simulated devices.
pub(crate) trait Simulated {
    /// What is wrong by injection with the exchange of a cycle of a period, ns.
    fn injected(&mut self, period: u64) -> Option<BusFault>;

    /// It follows its devices for a period, ns, that ends at `now`.
    fn advance(&mut self, period: u64, now: u64);
}

/// A simulated machine in virtual time.
#[derive(Debug, Clone)]
pub(crate) struct VirtualTime<M> {
    pub(crate) machine: M,
    /// ns.
    pub(crate) now: u64,
    /// When the cycle began, ns.
    begin: u64,
    /// What is wrong by injection in the cycle that has begun.
    pub(crate) injected: Option<BusFault>,
}

impl<M: Simulated> VirtualTime<M> {
    pub(crate) fn new(machine: M) -> Self {
        Self { machine, now: 0, begin: 0, injected: None }
    }

    /// Nothing happens until a time, ns.
    pub(crate) fn rest_until(&mut self, time: u64) {
        self.now = self.now.max(time);
    }

    /// What is due at a time, none for never, is waited for until a deadline, ns; the time then.
    pub(crate) fn wait(&mut self, due: Option<u64>, deadline: u64) -> u64 {
        self.rest_until(due.unwrap_or(u64::MAX).min(deadline));
        self.now
    }

    /// A cycle begins: the rest of the last one's period, ns, passes.
    pub(crate) fn begin_cycle(&mut self, period: u64) {
        self.begin = (self.begin + period).max(self.now);
        self.now = self.begin;
        self.injected = self.machine.injected(period);
        self.machine.advance(period, self.now);
    }
}
