use crate::Error;
use crate::error::within;

/// Period of the control cycle of a machine that says none, s.
pub const DEFAULT_PERIOD: f64 = 1e-3;

/// Shortest and longest period of a control cycle, s.
pub const PERIOD_RANGE: [f64; 2] = [5e-4, 0.02];

/// Largest age of a reading at the beginning of the cycle that uses it, s: sensors are sampled at least once
/// in a millisecond, whatever the period.
const READING_AGE: f64 = 1e-3;

/// Tolerance of a number of parts, 1: for periods that are sums.
const ROUNDING: f64 = 1e-9;

/// Checks a period, s.
pub(crate) fn check_period(period: f64) -> Result<f64, Error> {
    let [shortest, longest] = PERIOD_RANGE;
    let inside = (shortest..=longest).contains(&period);
    within("period", "a number in [0.0005, 0.02] s", period, inside)
}

/// Time from the measurement of a quantity to the middle of the interval in which the command that answers it
/// is held, s: the age of the reading, its transport, and half a period of hold.
#[must_use]
pub fn dead_time(period: f64, transport: f64) -> f64 {
    period.min(READING_AGE) + 0.5 * period + transport
}

/// Number of equal parts of an interval that are at most `longest` each; at least 1.
pub(crate) fn parts_of(interval: f64, longest: f64) -> usize {
    (libm::ceil(interval / longest - ROUNDING) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_a_millisecond_the_dead_time_is_a_cycle_and_half_a_cycle_of_hold_beside_the_transport() {
        assert!((dead_time(DEFAULT_PERIOD, 0.0) - 1.5e-3).abs() < 1e-15);
        assert!((dead_time(4e-3, 2e-3) - 5e-3).abs() < 1e-15);
        assert!((dead_time(5e-4, 0.0) - 7.5e-4).abs() < 1e-15);
    }

    #[test]
    fn an_interval_has_as_few_equal_parts_as_are_short_enough() {
        let parts = [1e-5, 5e-4, 1e-3, 1.000_001e-3, 1.5e-3, 2e-3, 3.0 * 1e-3, 0.02];
        assert_eq!(parts.map(|interval| parts_of(interval, 1e-3)), [1, 1, 1, 2, 2, 2, 3, 20]);
    }

    #[test]
    fn a_period_outside_of_half_a_millisecond_to_twenty_is_refused() {
        assert!([5e-4, 1e-3, 0.02].into_iter().all(|period| check_period(period).is_ok()));
        let wrong = [0.0, -1e-3, 4.9e-4, 0.0201, f64::NAN, f64::INFINITY];
        assert!(wrong.into_iter().all(|period| check_period(period).is_err()));
    }
}
