//! The numbers the method computes in: `f64`, and [`DoubleDouble`] where rounding would decide.

use super::settings::{Settings, Tolerances};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number in floating point.
pub(super) trait Scalar:
    Copy
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    const ZERO: Self;

    /// The nearest `f64`.
    fn rounded(self) -> f64;

    /// The tolerances for this precision.
    fn tolerances(settings: &Settings) -> &Tolerances;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;

    #[inline]
    fn rounded(self) -> f64 {
        self
    }

    #[inline]
    fn tolerances(settings: &Settings) -> &Tolerances {
        &settings.double
    }
}

/// The unevaluated sum `high + low` with `|low| <= ulp(high) / 2`: some 31 decimal digits.
///
/// # Source
/// Error-free sums and products: `dekker1971`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

/// `a + b` and its rounding error, where `|a| >= |b|`.
#[inline]
fn fast_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

/// `a + b` and its rounding error.
#[inline]
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let part = high - a;
    DoubleDouble { high, low: (a - (high - part)) + (b - part) }
}

/// Two numbers of 26 bits whose sum is `a`, so that products of such are exact.
#[inline]
fn split(a: f64) -> (f64, f64) {
    const FACTOR: f64 = 134_217_729.0; // 2^27 + 1
    let t = FACTOR * a;
    let high = t - (t - a);
    (high, a - high)
}

/// `a b` and its rounding error.
#[inline]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl Scalar for DoubleDouble {
    const ZERO: Self = Self { high: 0.0, low: 0.0 };

    #[inline]
    fn rounded(self) -> f64 {
        self.high
    }

    #[inline]
    fn tolerances(settings: &Settings) -> &Tolerances {
        &settings.double_double
    }
}

impl From<f64> for DoubleDouble {
    #[inline]
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let (s, t) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let u = fast_two_sum(s.high, s.low + t.high);
        fast_two_sum(u.high, u.low + t.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let p = two_product(self.high, other.high);
        fast_two_sum(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = Self;

    #[inline]
    fn mul(self, other: f64) -> Self {
        let p = two_product(self.high, other);
        fast_two_sum(p.high, p.low + self.low * other)
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first;
        let second = rest.high / other.high;
        let rest = rest - other * second;
        fast_two_sum(first, second) + Self::from(rest.high / other.high)
    }
}

impl AddAssign for DoubleDouble {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::{DoubleDouble, Scalar};

    #[test]
    fn digits_below_the_rounding_of_f64_are_kept() {
        let (one, small) = (DoubleDouble::from(1.0), DoubleDouble::from(3e-25));
        assert!((((one + small) - one).rounded() - 3e-25).abs() < 1e-31);
        let square = (one + small) * (one + small);
        assert!(((square - one).rounded() - 6e-25).abs() < 1e-30);
        let third = one / DoubleDouble::from(3.0);
        assert!((third * 3.0 - one).rounded().abs() < 1e-31);
    }
}
