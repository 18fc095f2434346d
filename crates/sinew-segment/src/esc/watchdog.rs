//! The process-data watchdog: outputs have to come in time.
//!
//! Source: ETG.1000.4, 6.3 and table 44 to 48.

/// The unit of the divider, ns.
const UNIT_NS: u64 = 40;

/// Time since the last outputs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watchdog {
    /// Outputs have come at least once and not in time since.
    pub(crate) expired: bool,
    started: bool,
    last: u64,
}

impl Watchdog {
    /// Outputs have come.
    pub(crate) fn trigger(&mut self, now: u64) {
        *self = Self { expired: false, started: true, last: now };
    }

    /// True at the moment at which it expires. `divider` and `time` are the registers.
    pub(crate) fn check(&mut self, now: u64, divider: u16, time: u16) -> bool {
        let limit = UNIT_NS * (u64::from(divider) + 2) * u64::from(time);
        let expires = self.started && time > 0 && !self.expired && now.saturating_sub(self.last) > limit;
        self.expired |= expires;
        expires
    }
}
