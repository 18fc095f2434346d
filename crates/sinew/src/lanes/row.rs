use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// The same quantity of `N` worlds. Without an alignment of its own, which would slow down a single world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<const N: usize>(pub(crate) [f64; N]);

/// A decision of every world: all bits set where it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mask<const N: usize>(pub(crate) [u64; N]);

impl<const N: usize> Default for Row<N> {
    fn default() -> Self {
        Self::all(0.0)
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $operator:tt),*) => { $(
        impl<const N: usize> $trait for Row<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..N {
                    self.0[k] $operator other.0[k];
                }
                self
            }
        }
        impl<const N: usize> $trait<Row<N>> for f64 {
            type Output = Row<N>;
            #[inline(always)]
            fn $method(self, other: Row<N>) -> Row<N> {
                Row::all(self).$method(other)
            }
        }
    )* };
}
lanewise!(Add add +=, Sub sub -=, Mul mul *=, Div div /=);

impl<const N: usize> Neg for Row<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..N {
            self.0[k] = -self.0[k];
        }
        self
    }
}

impl<const N: usize> AddAssign for Row<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> Row<N> {
    /// One number in every world.
    #[inline(always)]
    pub(crate) const fn all(x: f64) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    pub(crate) fn abs(mut self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].abs();
        }
        self
    }

    #[inline(always)]
    pub(crate) fn clamp(mut self, least: f64, most: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].clamp(least, most);
        }
        self
    }

    #[inline(always)]
    pub(crate) fn max(mut self, other: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].max(other);
        }
        self
    }

    #[inline(always)]
    pub(crate) fn min(mut self, other: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].min(other);
        }
        self
    }

    #[inline(always)]
    pub(crate) fn copysign(mut self, sign: Self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].copysign(sign.0[k]);
        }
        self
    }

    #[inline(always)]
    pub(crate) fn sqrt(mut self) -> Self {
        for k in 0..N {
            self.0[k] = crate::dispatch::sqrt(self.0[k]);
        }
        self
    }

    /// Sine and cosine.
    #[inline(always)]
    pub(crate) fn sincos(self) -> (Self, Self) {
        let (mut sine, mut cosine) = (self, self);
        for k in 0..N {
            (sine.0[k], cosine.0[k]) = libm::sincos(self.0[k]);
        }
        (sine, cosine)
    }

    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> Mask<N> {
        let mut mask = Mask::NONE;
        for k in 0..N {
            mask.0[k] = if self.0[k] < other.0[k] { !0 } else { 0 };
        }
        mask
    }

    /// Whether it is less or equal.
    #[inline(always)]
    pub(crate) fn at_most(self, other: Self) -> Mask<N> {
        let mut mask = Mask::NONE;
        for k in 0..N {
            mask.0[k] = if self.0[k] <= other.0[k] { !0 } else { 0 };
        }
        mask
    }

    #[inline(always)]
    pub(crate) fn is_finite(self) -> Mask<N> {
        self.abs().at_most(Self::all(f64::MAX))
    }

    /// Angle of the point `(x, y)`, `y` being `self`: bit-identical to `libm::atan2` for finite numbers.
    ///
    /// # Source
    /// Reduction and polynomial of `fdlibm1993`, with selections for branches.
    #[inline(always)]
    pub(crate) fn atan2(self, x: Self) -> Self {
        const HIGH: [f64; 4] = [4.636_476_090_008_061e-1, FRAC_PI_4, 9.827_937_232_473_29e-1, FRAC_PI_2];
        const LOW: [f64; 4] = [
            2.269_877_745_296_168_7e-17,
            3.061_616_997_868_383e-17,
            1.390_331_103_123_099_8e-17,
            6.123_233_995_736_766e-17,
        ];
        const A: [f64; 11] = [
            3.333_333_333_333_293e-1,
            -1.999_999_999_987_648_3e-1,
            1.428_571_427_250_346_6e-1,
            -1.111_111_040_546_235_6e-1,
            9.090_887_133_436_507e-2,
            -7.691_876_205_044_83e-2,
            6.661_073_137_387_531e-2,
            -5.833_570_133_790_573_5e-2,
            4.976_877_994_615_932_4e-2,
            -3.653_157_274_421_691_6e-2,
            1.628_582_011_536_578_2e-2,
        ];
        const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;
        let all = Self::all;
        let t = (self / x).abs();
        let (mut top, mut bottom, mut high, mut low) = (t, all(1.0), all(0.0), all(0.0));
        for (edge, tops, bottoms, k) in [
            (0.4375, 2.0 * t - all(1.0), 2.0 + t, 0),
            (0.6875, t - all(1.0), t + all(1.0), 1),
            (1.1875, t - all(1.5), 1.0 + 1.5 * t, 2),
            (2.4375, all(-1.0), t, 3),
        ] {
            let past = all(edge).at_most(t);
            (top, bottom) = (past.select(tops, top), past.select(bottoms, bottom));
            (high, low) = (past.select(all(HIGH[k]), high), past.select(all(LOW[k]), low));
        }
        let u = top / bottom;
        let z = u * u;
        let w = z * z;
        let even = z * (A[0] + w * (A[2] + w * (A[4] + w * (A[6] + w * (A[8] + w * all(A[10]))))));
        let odd = w * (A[1] + w * (A[3] + w * (A[5] + w * (A[7] + w * all(A[9])))));
        let angle = self.abs().at_most(all(0.0)).select(all(0.0), high - ((u * (even + odd) - low) - u));
        let (mut behind, mut steep) = (Mask::NONE, Mask::NONE);
        for k in 0..N {
            let (x, y) = (x.0[k].to_bits(), self.0[k].abs().to_bits());
            behind.0[k] = 0_u64.wrapping_sub(x >> 63);
            // Beyond a ratio of 2^64, by the upper halves of both numbers.
            steep.0[k] = if y >> 32 > (x << 1 >> 33) + (64 << 20) { !0 } else { 0 };
        }
        let angle = behind.select(PI - (angle - all(PI_LOW)), angle);
        steep.select(all(FRAC_PI_2), angle).copysign(self)
    }
}

impl<const N: usize> Mask<N> {
    /// In no world.
    pub(crate) const NONE: Self = Self([0; N]);

    /// The first where the mask holds, the second elsewhere.
    #[inline(always)]
    pub(crate) fn select(self, yes: Row<N>, mut no: Row<N>) -> Row<N> {
        for k in 0..N {
            no.0[k] = f64::from_bits((yes.0[k].to_bits() & self.0[k]) | (no.0[k].to_bits() & !self.0[k]));
        }
        no
    }

    /// Whether it holds in any world.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        let mut any = 0;
        for k in 0..N {
            any |= self.0[k];
        }
        any != 0
    }

    /// Whether it holds in every world.
    #[inline(always)]
    pub(crate) fn all(self) -> bool {
        !(!self).any()
    }
}

impl<const N: usize> BitAnd for Mask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] &= other.0[k];
        }
        self
    }
}

impl<const N: usize> BitOr for Mask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] |= other.0[k];
        }
        self
    }
}

impl<const N: usize> Not for Mask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(mut self) -> Self {
        for k in 0..N {
            self.0[k] = !self.0[k];
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::Row;

    #[test]
    fn the_angle_of_a_point_is_that_of_libm_to_the_bit() {
        let mut random = 1_u64;
        let mut number = |special: &[f64]| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (kind, bits) = ((random >> 59) as usize, random >> 12);
            // Exponents near one another, far apart, and special numbers.
            let size = [1.0, 1e-3, 1e3, 1e-9, 1e9, 1e-19, 1e19, 1e-30, 1e30][kind % 9];
            let sign = if bits & 1 == 0 { 1.0 } else { -1.0 };
            special.get(kind).map_or(size * sign * (bits as f64 / (1_u64 << 52) as f64), |x| sign * x)
        };
        for _ in 0..200_000 {
            let special = [0.0, 1.0, 0.4375, 0.6875, 1.1875, 2.4375, 3.0];
            let y = Row(core::array::from_fn::<_, 8, _>(|_| number(&special)));
            let x = Row(core::array::from_fn(|_| number(&special[..2])));
            let angles = y.atan2(x);
            for ((y, x), angle) in y.0.into_iter().zip(x.0).zip(angles.0) {
                let exact = libm::atan2(y, x);
                assert_eq!(angle.to_bits(), exact.to_bits(), "{y} {x}: {angle} {exact}");
                assert_eq!(Row([y]).atan2(Row([x])).0[0].to_bits(), exact.to_bits());
            }
        }
    }
}
