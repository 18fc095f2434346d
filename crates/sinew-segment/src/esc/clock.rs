//! The distributed clock of a device: local time, system time, the control that follows a reference, SYNC0
//! and SYNC1.
//!
//! Source: ETG.1000.4, 6.8 and table 60, 61. The standard leaves the control law open; here it is
//! proportional and integral with critical damping, in place of the steps of one nanosecond by which hardware
//! follows.

/// Limit of the correction of the rate, ppb.
const MAX_RATE_PPB: i64 = 1_000_000;
/// Limit of one correction of the phase, ns.
const MAX_STEP_NS: i64 = 10_000;
/// Proportional fraction of a difference; the integral fraction is its square over four: critical damping.
const FRACTION: i64 = 16;
const BILLION: i64 = 1_000_000_000;

/// Pulses in an interval of virtual time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SyncPulses {
    pub(crate) sync0: u64,
}

/// Clock of one device.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    local: u64,
    drift_ppb: i64,
    rate_ppb: i64,
    /// Billionths of a nanosecond that are not yet in `local`.
    rest: i64,
    /// System time minus local time, as the master has written it.
    pub(crate) offset: u64,
    /// From the reference to this device, ns.
    pub(crate) delay: u32,
    mean: i64,
    last_update: Option<u64>,
    next_sync0: Option<u64>,
    cycle0: u32,
}

impl Clock {
    pub(crate) fn new(start: u64, drift_ppb: i32) -> Self {
        Self {
            local: start,
            drift_ppb: i64::from(drift_ppb),
            rate_ppb: 0,
            rest: 0,
            offset: 0,
            delay: 0,
            mean: 0,
            last_update: None,
            next_sync0: None,
            cycle0: 0,
        }
    }

    /// Local time, ns.
    pub(crate) fn local(&self) -> u64 {
        self.local
    }

    /// System time, ns.
    pub(crate) fn system(&self) -> u64 {
        self.local.wrapping_add(self.offset)
    }

    /// Mean difference to the reference as in its register: magnitude, and bit 31 where the local time is
    /// behind.
    pub(crate) fn difference(&self) -> u32 {
        let magnitude = u32::try_from(self.mean.unsigned_abs()).unwrap_or(u32::MAX) & 0x7fff_ffff;
        magnitude | if self.mean < 0 { 0x8000_0000 } else { 0 }
    }

    /// Virtual time passes.
    pub(crate) fn advance(&mut self, nanoseconds: u64) -> SyncPulses {
        let rate = self.drift_ppb + self.rate_ppb;
        let extra = i128::from(nanoseconds) * i128::from(rate) + i128::from(self.rest);
        let (whole, rest) = if let Ok(small) = i64::try_from(extra) {
            (small.div_euclid(BILLION), small.rem_euclid(BILLION))
        } else {
            (extra.div_euclid(i128::from(BILLION)) as i64, extra.rem_euclid(i128::from(BILLION)) as i64)
        };
        self.rest = rest;
        self.local = self.local.wrapping_add(nanoseconds).wrapping_add_signed(whole);
        self.pulses()
    }

    fn pulses(&mut self) -> SyncPulses {
        let (Some(next), now) = (self.next_sync0, self.system()) else { return SyncPulses::default() };
        if now < next {
            return SyncPulses::default();
        }
        // A cycle of 0 is a single pulse.
        let Some(more) = (now - next).checked_div(u64::from(self.cycle0)) else {
            self.next_sync0 = None;
            return SyncPulses { sync0: 1 };
        };
        self.next_sync0 = Some(next.saturating_add((more + 1).saturating_mul(u64::from(self.cycle0))));
        SyncPulses { sync0: more + 1 }
    }

    /// The reference's time has arrived, in its low 32 bits or all of them, `later` ns after the present.
    pub(crate) fn follow(&mut self, received: u64, wide: bool, filter_depth: u8, later: u64) {
        let expected = received.wrapping_add(u64::from(self.delay));
        let all = self.system().wrapping_add(later).wrapping_sub(expected);
        let difference = if wide { all as i64 } else { i64::from(all as u32 as i32) };
        self.mean += (difference - self.mean) >> filter_depth.min(12);
        let step = (difference / FRACTION).clamp(-MAX_STEP_NS, MAX_STEP_NS);
        if let Some(last) = self.last_update
            && let Ok(interval @ 1..=BILLION) = i64::try_from(self.local.wrapping_sub(last))
            && difference.abs() < FRACTION * MAX_STEP_NS
        {
            let change = difference * BILLION / interval / (4 * FRACTION * FRACTION);
            self.rate_ppb = (self.rate_ppb - change).clamp(-MAX_RATE_PPB, MAX_RATE_PPB);
        }
        self.local = self.local.wrapping_add_signed(-step);
        self.last_update = Some(self.local);
    }

    /// Forgets what the control has learned (speed counter written).
    pub(crate) fn reset_control(&mut self) {
        (self.mean, self.last_update, self.rate_ppb) = (0, None, 0);
    }

    /// The SYNC unit is switched on or off. False where the start lies in the past: no pulse will come.
    pub(crate) fn activate(&mut self, on: bool, start: u64, cycle0: u32) -> bool {
        self.cycle0 = cycle0;
        let future = start > self.system();
        self.next_sync0 = (on && future).then_some(start);
        !on || future
    }

    /// System time of the next pulse of SYNC0.
    pub(crate) fn next_sync0(&self) -> Option<u64> {
        self.next_sync0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drifting_clock_is_pulled_to_its_reference() {
        let mut clock = Clock::new(123_456, 40_000);
        let mut time: u64 = 1_000_000;
        for _ in 0..4000 {
            clock.advance(1_000_000);
            time += 1_000_000;
            clock.follow(time, true, 4, 0);
        }
        let error = clock.system().wrapping_sub(time) as i64;
        assert!(error.abs() < 20, "{error} ns");
        // One nanosecond in a cycle of a millisecond is the smallest step: 1000 ppb.
        assert!((clock.rate_ppb + 40_000).abs() < 1000, "{} ppb", clock.rate_ppb);
    }

    #[test]
    fn pulses_are_counted_however_long_the_interval() {
        let mut clock = Clock::new(0, 0);
        assert!(clock.activate(true, 500, 1000));
        assert_eq!(clock.advance(499).sync0, 0);
        assert_eq!(clock.advance(1).sync0, 1);
        assert_eq!(clock.advance(1_000_000_000).sync0, 1_000_000);
        assert_eq!(clock.next_sync0(), Some(1_000_001_500));
        assert!(!clock.activate(true, 3, 1000), "a start in the past");
    }
}
