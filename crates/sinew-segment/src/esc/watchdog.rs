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

    /// The time that the registers of divider and watchdog say, ns; 0 switches it off.
    pub(crate) fn limit_ns(divider: u16, time: u16) -> u64 {
        UNIT_NS * (u64::from(divider) + 2) * u64::from(time)
    }

    /// True at the moment at which it expires.
    pub(crate) fn check(&mut self, now: u64, limit_ns: u64) -> bool {
        let late = now.saturating_sub(self.last) > limit_ns;
        let expires = self.started && limit_ns > 0 && !self.expired && late;
        self.expired |= expires;
        expires
    }
}
