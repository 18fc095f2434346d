//! Domains of numbers, in words and as conditions.

/// Largest magnitude of a number in a file, in SI units: no length, mass, force or count of a machine is near
/// it, and squares and products of such numbers are still finite.
pub(in crate::description) const LARGEST: f64 = 1e12;
/// The same in words.
pub(in crate::description) const AT_MOST_LARGEST: &str = "a number of magnitude up to 1e12";

/// Finite numbers that fulfil a condition.
#[derive(Debug, Clone, Copy)]
pub struct Domain {
    /// In words.
    pub(in crate::description) expected: &'static str,
    holds: fn(f64) -> bool,
}

impl Domain {
    /// Numbers as expected in words, for which a condition holds.
    #[must_use]
    pub const fn new(expected: &'static str, holds: fn(f64) -> bool) -> Self {
        Self { expected, holds }
    }

    pub(in crate::description) fn contains(self, number: f64) -> bool {
        number.is_finite() && (self.holds)(number)
    }
}

pub(in crate::description) const FINITE: Domain = Domain { expected: "a finite number", holds: |_| true };
pub(in crate::description) const NON_NEGATIVE: Domain =
    Domain { expected: "a finite number >= 0", holds: |x| x >= 0.0 };
pub(in crate::description) const POSITIVE: Domain =
    Domain { expected: "a finite number > 0", holds: |x| x > 0.0 };
pub(in crate::description) const FROM_ONE: Domain =
    Domain { expected: "a finite number >= 1", holds: |x| x >= 1.0 };
pub(in crate::description) const BELOW_ONE: Domain =
    Domain { expected: "a number in [0, 1)", holds: |x| (0.0..1.0).contains(&x) };
pub(in crate::description) const UP_TO_ONE: Domain =
    Domain { expected: "a number in (0, 1]", holds: |x| x > 0.0 && x <= 1.0 };
pub(in crate::description) const LAYERS: Domain = Domain {
    expected: "a whole number in 1..=8",
    holds: |x| (1..=8).any(|layers| f64::from(layers).to_bits() == x.to_bits()),
};
pub(in crate::description) const LAG: Domain =
    Domain { expected: "a finite number >= 0.005", holds: |x| x >= 0.005 };
pub(in crate::description) const HOTTER_THAN_ROOM: Domain =
    Domain { expected: "a finite number > 25", holds: |x| x > 25.0 };
pub(in crate::description) const DELAY: Domain =
    Domain { expected: "a number in [0, 10]", holds: |x| (0.0..=10.0).contains(&x) };
pub(in crate::description) const PERIOD: Domain =
    Domain { expected: "a number in [0.0005, 0.02]", holds: |x| (0.0005..=0.02).contains(&x) };
pub(in crate::description) const NOT_ZERO: Domain =
    Domain { expected: "a finite number other than 0", holds: |x| x != 0.0 };
