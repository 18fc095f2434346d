use super::locked_winches::{MAX_UNSTABLE_RATE, unstable_rates};
use super::pace::{MIN_OBSERVER_RATIO, OBSERVER_STEP, Pace};
use crate::Error;
use crate::machine::{DEFAULT_PERIOD, Machine, PERIOD_RANGE, dead_time};
use crate::transmission::cable::CableLaw;
use alloc::vec::Vec;

/// What the period of a machine's control cycle costs, and how slow it may be.
///
/// ```text
/// tracked at T:   rate <= 100 1/s D_0/max(D, D_0)   and   w <= w_o,T/3
/// ```
///
/// with the symbols of the rules at [`synthesize`](super::synthesize); `rate` is that at which the machine
/// leaves a pose by itself while its winches are held.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodCost {
    /// `D`, s.
    pub dead_time: f64,
    /// `t_v` at this period and at a millisecond, s.
    pub winch_time: [f64; 2],
    /// `c`, rad/s, the same.
    pub damping_crossover: [f64; 2],
    /// `w_o`, rad/s, the same.
    pub observer_bandwidth: [f64; 2],
    /// `r w_o`, rad/s, the same: of an observer that follows a joint as it breaks away.
    pub fastest_observer: [f64; 2],
    /// `w`, rad/s, the same.
    pub bandwidth: [f64; 2],
    /// Of every joint: `[joints]`.
    pub slowest: Vec<SlowestPeriod>,
}

/// The slowest period at which a joint is tracked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowestPeriod {
    /// s; below that of the machine where the joint is not tracked.
    pub period: f64,
    /// What does not allow a slower one.
    pub limited_by: PeriodLimit,
}

/// What limits the period of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PeriodLimit {
    /// With locked winches it leaves a pose by itself at this rate, 1/s.
    Instability(f64),
    /// Its observer is to be three times as fast as it at least: beyond, it follows its reference more
    /// slowly.
    Bandwidth,
    /// Nothing within the range of periods.
    Range,
}

/// Rate at which a machine with this dead time, s, may leave a pose by itself and still be tracked, 1/s: that
/// of a millisecond, [`MAX_UNSTABLE_RATE`], with the same growth within the dead time.
#[must_use]
pub fn max_unstable_rate(dead_time_s: f64) -> f64 {
    MAX_UNSTABLE_RATE * (dead_time(DEFAULT_PERIOD, 0.0) / dead_time_s).min(1.0)
}

impl PeriodCost {
    /// Of a machine with its payload in the body.
    ///
    /// # Shapes
    /// `laws: [muscles]`, `poses: [places][joints]`.
    ///
    /// # Errors
    /// As [`least_stable_pose`](super::least_stable_pose).
    pub fn new(machine: &Machine, laws: &[CableLaw], poses: &[Vec<f64>]) -> Result<Self, Error> {
        let own = Pace::from_machine(machine);
        let usual = Pace::new(&machine.rules, DEFAULT_PERIOD, 0.0);
        let of = |number: fn(&Pace) -> f64| [number(&own), number(&usual)];
        let transport = machine.transport_delay();
        let by_bandwidth = OBSERVER_STEP / (MIN_OBSERVER_RATIO * machine.rules.bandwidth);
        let rates = unstable_rates(machine, laws, poses)?;
        Ok(Self {
            dead_time: machine.dead_time(),
            winch_time: of(|pace| pace.stretch_time_constant),
            damping_crossover: of(|pace| pace.rules.damping_crossover),
            observer_bandwidth: of(|pace| pace.rules.observer_bandwidth),
            fastest_observer: of(|pace| pace.max_bandwidth_ratio * pace.rules.observer_bandwidth),
            bandwidth: of(|pace| pace.rules.bandwidth),
            slowest: rates.into_iter().map(|rate| slowest(rate, by_bandwidth, transport)).collect(),
        })
    }

    /// The joints that cannot be held at the machine's period, with their slowest.
    pub fn unheld(&self, period: f64) -> impl Iterator<Item = (usize, SlowestPeriod)> {
        let held = move |slowest: &SlowestPeriod| {
            slowest.period >= period || !matches!(slowest.limited_by, PeriodLimit::Instability(_))
        };
        self.slowest.iter().copied().enumerate().filter(move |(_, slowest)| !held(slowest))
    }
}

/// Of a joint that leaves a pose at a rate, 1/s.
fn slowest(rate: f64, by_bandwidth: f64, transport: f64) -> SlowestPeriod {
    let longest = PERIOD_RANGE[1];
    let by_rate = if rate > 0.0 {
        let left = dead_time(DEFAULT_PERIOD, 0.0) * MAX_UNSTABLE_RATE / rate - transport;
        // The inverse of `dead_time`.
        let fast = left <= dead_time(DEFAULT_PERIOD, 0.0);
        if fast { left / 1.5 } else { 2.0 * (left - DEFAULT_PERIOD) }
    } else {
        f64::INFINITY
    };
    if by_rate < longest && by_rate <= by_bandwidth {
        SlowestPeriod { period: by_rate.max(0.0), limited_by: PeriodLimit::Instability(rate) }
    } else if by_bandwidth < longest {
        SlowestPeriod { period: by_bandwidth, limited_by: PeriodLimit::Bandwidth }
    } else {
        SlowestPeriod { period: longest, limited_by: PeriodLimit::Range }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_period_of_an_unstable_joint_is_the_one_whose_rate_is_the_largest_that_is_held() {
        for (rate, transport) in [(30.0, 0.0), (60.0, 0.0), (150.0, 0.0), (40.0, 1e-3)] {
            let found = slowest(rate, 0.02, transport);
            assert_eq!(found.limited_by, PeriodLimit::Instability(rate));
            let most = max_unstable_rate(dead_time(found.period, transport));
            // At a millisecond and below the largest rate is that of a millisecond.
            let expected = if rate < MAX_UNSTABLE_RATE { rate } else { MAX_UNSTABLE_RATE };
            assert!((most / expected - 1.0).abs() < 1e-9, "{rate}: {found:?} {most}");
        }
    }

    #[test]
    fn a_stable_joint_is_limited_by_its_observer_and_a_slow_one_by_nothing() {
        let found = slowest(0.0, 0.01, 0.0);
        assert_eq!((found.period, found.limited_by), (0.01, PeriodLimit::Bandwidth));
        let found = slowest(0.0, 0.03, 0.0);
        assert_eq!((found.period, found.limited_by), (0.02, PeriodLimit::Range));
    }

    #[test]
    fn at_a_millisecond_nothing_is_lost_and_slower_cycles_lose_more() {
        let rules = crate::machine::ControlRules::default();
        let paces = [1e-3, 2e-3, 5e-3, 0.02].map(|period| Pace::new(&rules, period, 0.0));
        assert_eq!(paces[0].rules, rules);
        assert_eq!(paces[0].stretch_time_constant.to_bits(), 0.0056_f64.to_bits());
        for pair in paces.windows(2) {
            assert!(pair[1].stretch_time_constant > pair[0].stretch_time_constant);
            assert!(pair[1].rules.damping_crossover < pair[0].rules.damping_crossover);
            let fastest = |pace: &Pace| pace.max_bandwidth_ratio * pace.rules.observer_bandwidth;
            assert!(fastest(&pair[1]) < fastest(&pair[0]) && fastest(&pair[1]) * pair[1].period < 0.53);
            assert!(3.0 * pair[1].rules.bandwidth <= pair[1].rules.observer_bandwidth + 1e-12);
        }
        // Half a millisecond asks for no more than a millisecond, and transport counts at any period.
        assert_eq!(Pace::new(&rules, 5e-4, 0.0).rules, rules);
        assert!((Pace::new(&rules, 1e-3, 1.5e-3).rules.damping_crossover - 30.0).abs() < 1e-9);
    }
}
