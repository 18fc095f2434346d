//! Numbers of twice the digits: the sum of two, the second below the rounding of the first.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `high + low`, some 31 digits.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub(super) struct Twofold {
    high: f64,
    low: f64,
}

/// `a + b` and what rounding took from it, where `|a| >= |b|`.
#[inline(always)]
fn quick_sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    Twofold { high, low: b - (high - a) }
}

/// The same for any two.
#[inline(always)]
fn sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    let part = high - a;
    Twofold { high, low: (a - (high - part)) + (b - part) }
}

/// Halves of the digits, whose products are exact.
#[inline(always)]
fn halves(a: f64) -> (f64, f64) {
    const SPLIT: f64 = 134_217_729.0; // 2^27 + 1
    let t = SPLIT * a;
    let high = t - (t - a);
    (high, a - high)
}

/// `a b` and what rounding took from it.
#[inline(always)]
fn product(a: f64, b: f64) -> Twofold {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
    Twofold { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl Twofold {
    pub(super) const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// The nearest ordinary number.
    #[inline(always)]
    pub(super) fn rounded(self) -> f64 {
        self.high
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }
}

impl From<f64> for Twofold {
    #[inline(always)]
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Twofold {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (s, t) = (sum(self.high, other.high), sum(self.low, other.low));
        let u = quick_sum(s.high, s.low + t.high);
        quick_sum(u.high, u.low + t.low)
    }
}

impl Neg for Twofold {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Twofold {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let p = product(self.high, other.high);
        quick_sum(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Mul<f64> for Twofold {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let p = product(self.high, other);
        quick_sum(p.high, p.low + self.low * other)
    }
}

impl Div for Twofold {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first;
        let second = rest.high / other.high;
        let rest = rest - other * second;
        quick_sum(first, second) + Self::from(rest.high / other.high)
    }
}

impl AddAssign for Twofold {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Twofold {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::Twofold;

    #[test]
    fn what_an_ordinary_number_would_lose_is_kept() {
        let (one, small) = (Twofold::from(1.0), Twofold::from(3e-25));
        assert!((((one + small) - one).rounded() - 3e-25).abs() < 1e-31);
        let square = (one + small) * (one + small);
        assert!(((square - one).rounded() - 6e-25).abs() < 1e-30);
        let third = one / Twofold::from(3.0);
        assert!((third * 3.0 - one).abs().rounded() < 1e-31);
    }
}
