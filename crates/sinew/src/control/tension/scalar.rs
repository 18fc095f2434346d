//! The numbers the method computes in: `f64`, and [`Wide`] where rounding would decide.

use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number in floating point.
pub(super) trait Scalar:
    Copy
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
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

const LIMBS: usize = 8;
const BITS: u32 = 64 * LIMBS as u32;

/// A floating-point number of 512 bits, some 154 digits, truncated instead of rounded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide {
    negative: bool,
    exponent: i32,
    /// Least first, as a fraction of `2^exponent`; the highest bit is set unless the number is zero.
    limbs: [u64; LIMBS],
}

impl Wide {
    fn normalized(negative: bool, exponent: i32, limbs: [u64; LIMBS]) -> Self {
        let empty = limbs.iter().rev().take_while(|limb| **limb == 0).count();
        if empty == LIMBS {
            return Self::ZERO;
        }
        let bits = limbs[LIMBS - 1 - empty].leading_zeros();
        let at = |k: usize| if k >= empty { limbs[k - empty] } else { 0 };
        let shifted = core::array::from_fn(|k| match (bits, k) {
            (0, _) => at(k),
            (_, 0) => at(k) << bits,
            _ => at(k) << bits | at(k - 1) >> (64 - bits),
        });
        Self { negative, exponent: exponent - (64 * empty as i32 + bits as i32), limbs: shifted }
    }

    fn shifted_right(&self, shift: u32) -> [u64; LIMBS] {
        let (whole, bits) = (shift as usize / 64, shift % 64);
        let at = |k: usize| self.limbs.get(k + whole).copied().unwrap_or(0);
        core::array::from_fn(|k| if bits == 0 { at(k) } else { at(k) >> bits | at(k + 1) << (64 - bits) })
    }

    fn is_zero(&self) -> bool {
        self.limbs[LIMBS - 1] == 0
    }

    fn compare_magnitude(&self, other: &Self) -> Ordering {
        let exponent = |x: &Self| (!x.is_zero(), x.exponent);
        exponent(self)
            .cmp(&exponent(other))
            .then_with(|| self.limbs.iter().rev().cmp(other.limbs.iter().rev()))
    }
}

impl Scalar for Wide {
    const ZERO: Self = Self { negative: false, exponent: 0, limbs: [0; LIMBS] };

    fn rounded(self) -> f64 {
        let high = u128::from(self.limbs[LIMBS - 1]) << 64 | u128::from(self.limbs[LIMBS - 2]);
        let x = libm::ldexp(high as f64, self.exponent - 128);
        if self.negative { -x } else { x }
    }
}

impl From<f64> for Wide {
    /// Exact; an infinity becomes `2^1024`.
    fn from(x: f64) -> Self {
        let bits = x.to_bits();
        let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
        let mut limbs = [0; LIMBS];
        limbs[LIMBS - 1] = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        Self::normalized(x < 0.0, exponent.max(1) - 1011, limbs)
    }
}

impl PartialEq for Wide {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let sign = |x: &Self| i32::from(!x.is_zero()) * if x.negative { -1 } else { 1 };
        let (a, b) = (sign(self), sign(other));
        let magnitudes = || if a < 0 { other.compare_magnitude(self) } else { self.compare_magnitude(other) };
        Some(a.cmp(&b).then_with(magnitudes))
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        Self { negative: !self.negative, ..self }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (large, small) =
            if self.compare_magnitude(&other).is_lt() { (other, self) } else { (self, other) };
        let distance = large.exponent.abs_diff(small.exponent);
        if small.is_zero() || distance >= BITS {
            return large;
        }
        let subtract = large.negative != small.negative;
        let (mut sum, mut carry) = (large.limbs, subtract);
        for (limb, small) in sum.iter_mut().zip(small.shifted_right(distance)) {
            let (part, first) = limb.overflowing_add(if subtract { !small } else { small });
            let (whole, second) = part.overflowing_add(u64::from(carry));
            (*limb, carry) = (whole, first | second);
        }
        if subtract || !carry {
            return Self::normalized(large.negative, large.exponent, sum);
        }
        let mut limbs = Self { limbs: sum, ..large }.shifted_right(1);
        limbs[LIMBS - 1] |= 1 << 63;
        Self { exponent: large.exponent + 1, limbs, ..large }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let mut product = [0_u64; 2 * LIMBS];
        for (i, a) in self.limbs.iter().enumerate() {
            let mut carry = 0;
            for (j, b) in other.limbs.iter().enumerate() {
                let sum = u128::from(*a) * u128::from(*b) + u128::from(product[i + j]) + carry;
                product[i + j] = sum as u64;
                carry = sum >> 64;
            }
            product[i + LIMBS] = carry as u64;
        }
        let high = core::array::from_fn(|k| product[k + LIMBS]);
        Self::normalized(self.negative != other.negative, self.exponent + other.exponent, high)
    }
}

impl Div for Wide {
    type Output = Self;

    /// By Newton's iteration for the reciprocal, which doubles the digits; zero for a divisor of zero.
    fn div(self, other: Self) -> Self {
        let unit = Self { exponent: 0, ..other };
        if unit.is_zero() {
            return Self::ZERO;
        }
        let mut reciprocal = Self::from(1.0 / unit.rounded());
        for _ in 0..4 {
            reciprocal += reciprocal * (Self::from(1.0) - reciprocal * unit);
        }
        let quotient = self * reciprocal;
        Self { exponent: quotient.exponent - other.exponent, ..quotient }
    }
}

impl AddAssign for Wide {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Wide {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
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
        assert!(one - one == -Wide::ZERO);
    }
}
