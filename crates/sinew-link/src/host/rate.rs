//! Limits of rates.

/// A token bucket: a mean rate and a bounded burst.
#[derive(Debug, Clone, Copy)]
pub struct RateLimit {
    /// Between events at the mean rate, ns; 0 without limit.
    period: u64,
    /// Events allowed at once; 0 acts as 1.
    burst: u64,
    /// Theoretical arrival time: when the bucket is full again, ns.
    full_at: u64,
}

impl RateLimit {
    /// At most `per_second` events per second in the mean, and `burst` at once; a rate of 0 is without limit.
    ///
    /// # Source
    /// The virtual scheduling algorithm, ITU-T I.371.
    #[must_use]
    pub fn new(per_second: u32, burst: u32) -> Self {
        let period = 1_000_000_000_u64.checked_div(u64::from(per_second)).unwrap_or(0);
        Self { period, burst: u64::from(burst), full_at: 0 }
    }

    /// Whether one more event is allowed at the time `now`, ns; an allowed event is counted.
    pub fn allow(&mut self, now: u64) -> bool {
        let begin = self.full_at.max(now);
        if begin - now > self.period * self.burst.saturating_sub(1) {
            return false;
        }
        self.full_at = begin + self.period;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_rate_and_the_burst_are_kept() {
        let mut limit = RateLimit::new(1000, 10);
        assert_eq!((0..100).filter(|_| limit.allow(5)).count(), 10);
        let allowed = (0..1_000_000_u64).filter(|k| limit.allow(1000 * k)).count();
        assert!((990..=1010).contains(&allowed), "{allowed} in a second");
        let mut none = RateLimit::new(0, 1);
        assert!((0..10_000).all(|_| none.allow(0)), "0 is without limit");
    }
}
