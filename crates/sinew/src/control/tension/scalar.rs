//! The numbers the method computes in: `f64`, and [`Wide`] where rounding would decide.

use core::cmp::Ordering;
use core::ops::{Add, Div, Mul, Sub};
use ruint::aliases::U512;

/// A real number in floating point.
pub(super) trait Scalar:
    Copy
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    const ZERO: Self;

    /// The nearest `f64`.
    fn rounded(self) -> f64;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;

    #[inline]
    fn rounded(self) -> f64 {
        self
    }
}

/// A floating-point number of 512 bits, some 154 digits, truncated instead of rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wide {
    negative: bool,
    exponent: i32,
    /// As a part of `2^exponent`; the highest bit is set unless the number is zero.
    fraction: U512,
}

/// Room for a product and a dividend.
type U1024 = ruint::Uint<1024, 16>;

impl Wide {
    fn normalized(negative: bool, exponent: i32, fraction: U512) -> Self {
        let shift = fraction.leading_zeros();
        if shift == U512::BITS {
            return Self::ZERO;
        }
        Self { negative, exponent: exponent - shift as i32, fraction: fraction << shift }
    }
}

impl Scalar for Wide {
    const ZERO: Self = Self { negative: false, exponent: i32::MIN / 2, fraction: U512::ZERO };

    fn rounded(self) -> f64 {
        let high: u128 = (self.fraction >> 384_usize).to();
        let x = libm::ldexp(high as f64, self.exponent - 128);
        if self.negative { -x } else { x }
    }
}

impl From<f64> for Wide {
    /// Exact; an infinity becomes `2^1024`.
    fn from(x: f64) -> Self {
        let bits = x.to_bits();
        let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
        let fraction = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        Self::normalized(x < 0.0, exponent.max(1) - 1011 + 448, U512::from(fraction))
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let Self { negative, fraction, .. } = *self - *other;
        Some(if negative { Ordering::Less } else { fraction.cmp(&U512::ZERO) })
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let is_smaller = (self.exponent, self.fraction) < (other.exponent, other.fraction);
        let (large, small) = if is_smaller { (other, self) } else { (self, other) };
        let distance = large.exponent.abs_diff(small.exponent) as usize;
        let small_fraction = small.fraction.wrapping_shr(distance);
        if large.negative != small.negative {
            return Self::normalized(large.negative, large.exponent, large.fraction - small_fraction);
        }
        let (sum, carry) = large.fraction.overflowing_add(small_fraction);
        let fraction = if carry { sum >> 1_usize | U512::ONE << 511_usize } else { sum };
        Self { exponent: large.exponent + i32::from(carry), fraction, ..large }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self { negative: !other.negative, ..other }
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product: U1024 = self.fraction.widening_mul(other.fraction);
        let high = U512::from_limbs_slice(&product.as_limbs()[8..]);
        Self::normalized(self.negative != other.negative, self.exponent + other.exponent, high)
    }
}

impl Div for Wide {
    type Output = Self;

    /// Zero for a divisor of zero.
    fn div(self, other: Self) -> Self {
        let dividend: U1024 = U1024::from(self.fraction) << 511_usize;
        let quotient = dividend.checked_div(U1024::from(other.fraction)).unwrap_or_default();
        let exponent = self.exponent - other.exponent + 1;
        Self::normalized(self.negative != other.negative, exponent, U512::from(quotient))
    }
}

#[cfg(test)]
mod tests {
    use super::{Scalar, Wide};

    #[test]
    fn digits_far_below_the_rounding_of_f64_are_kept() {
        let (one, small) = (Wide::from(1.0), Wide::from(-3e-100));
        assert!(((one + small - one).rounded() / -3e-100 - 1.0).abs() < 1e-12);
        let square = (one + small) * (one + small);
        assert!(((square - one).rounded() / -6e-100 - 1.0).abs() < 1e-12);
        let third = one / Wide::from(3.0);
        assert!((third + third + third - one).rounded().abs() < 1e-114);
        for x in [1.0, -2.5, 1e300, -1e-300, 5e-324, 0.0, f64::INFINITY, 1.0 / 3.0] {
            assert_eq!(Wide::from(x).rounded().to_bits(), x.to_bits());
        }
        assert!(Wide::from(-2.0) < Wide::from(-1.0) && Wide::ZERO < third && third < one);
        assert!(one - one == Wide::ZERO && Wide::from(-0.0) == Wide::ZERO);
    }
}
