use super::row::{Mask, Row};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

impl<const N: usize> Row<N> {
    /// Sine and cosine: bit-identical to `libm::sincos`.
    ///
    /// # Source
    /// Reduction and polynomials of `fdlibm1993`, with selections for branches.
    #[inline(always)]
    pub(crate) fn sincos(self) -> (Self, Self) {
        // pi/2 in two parts; the first has 20 zero low bits.
        const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
        const S: [f64; 6] = [
            -1.666_666_666_666_663_2e-1,
            8.333_333_333_322_49e-3,
            -1.984_126_982_985_795e-4,
            2.755_731_370_707_006_8e-6,
            -2.505_076_025_340_686_3e-8,
            1.589_690_995_211_55e-10,
        ];
        const C: [f64; 6] = [
            4.166_666_666_666_66e-2,
            -1.388_888_888_887_411e-3,
            2.480_158_728_947_673e-5,
            -2.755_731_435_139_066_3e-7,
            2.087_572_321_298_175e-9,
            -1.135_964_755_778_819_5e-11,
        ];
        let all = Self::all;
        let (size, none) = (self.abs(), Self::default());
        // Up to 9/4 pi, but next to a quarter turn, where digits cancel: by the upper halves of the numbers.
        let mut plain = size.less(Self::above(0x401c_463b));
        for quarter in [0x3ff9_21fb, 0x4009_21fb, 0x4012_d97c, 0x4019_21fb] {
            plain = plain & (size.less(Self::above(quarter - 1)) | Self::above(quarter).at_most(size));
        }
        if N == 1 || !plain.all() {
            return self.sincos_one_by_one();
        }
        let mut turns = none;
        for edge in [0x3fe9_21fb, 0x4002_d97c, 0x400f_6a7a, 0x4015_fdbc] {
            turns += Self::above(edge).at_most(size).select(all(1.0), none);
        }
        let unturned = turns.less(all(1.0));
        let signed = turns.copysign(self);
        let (high, low) = (signed * all(HALF_PI[0]), signed * all(HALF_PI[1]));
        let far = self - high;
        let x = far - low;
        let y = (far - x) - low;
        let z = x * x;
        let w = z * z;
        let v = z * x;
        let r = all(S[1]) + z * (all(S[2]) + z * all(S[3])) + z * w * (all(S[4]) + z * all(S[5]));
        let turned = x - ((z * (0.5 * y - v * r) - y) - v * all(S[0]));
        let sine = unturned.select(x + v * (all(S[0]) + z * r), turned);
        let r = z * (all(C[0]) + z * (all(C[1]) + z * all(C[2])))
            + w * w * (all(C[3]) + z * (all(C[4]) + z * all(C[5])));
        let half = 0.5 * z;
        let whole = 1.0 - half;
        let cosine = whole + (((1.0 - whole) - half) + (z * r - x * y));
        let tiny = size.less(Self::above(0x3e46_a09d));
        let (sine, cosine) = (tiny.select(self, sine), tiny.select(all(1.0), cosine));
        let (back, one) = (self.less(none), turns.is(1.0));
        let (two, three) = (turns.is(2.0), turns.is(3.0));
        let odd = one | three;
        let (sine, cosine) = (odd.select(cosine, sine), odd.select(sine, cosine));
        let sine = (two | (one & back) | (three & !back)).select(-sine, sine);
        let cosine = (two | (one & !back) | (three & back)).select(-cosine, cosine);
        (sine, cosine)
    }

    fn sincos_one_by_one(self) -> (Self, Self) {
        let (mut sine, mut cosine) = (self, self);
        for k in 0..N {
            (sine.0[k], cosine.0[k]) = libm::sincos(self.0[k]);
        }
        (sine, cosine)
    }

    /// The first number above those with this upper half.
    #[inline(always)]
    fn above(high: u32) -> Self {
        Self::all(f64::from_bits((high as u64 + 1) << 32))
    }

    /// Whether it is this number.
    #[inline(always)]
    fn is(self, x: f64) -> Mask<N> {
        self.at_most(Self::all(x)) & Self::all(x).at_most(self)
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

#[cfg(test)]
mod tests {
    use super::Row;

    #[test]
    fn sine_and_cosine_are_those_of_libm_to_the_bit() {
        let mut state = 3_u64;
        let mut bits = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state.rotate_left(32) ^ state
        };
        let edges = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 9.0].map(|k| k * core::f64::consts::FRAC_PI_4);
        // Between -2 and 2.
        let wide = |bits: u64| bits as i64 as f64 / (1_u64 << 62) as f64;
        let mut vectorised = 0;
        for k in 0..300_000 {
            let mut angle = |_| {
                let near = edges[(bits() >> 61) as usize];
                // Around edges from wide to next to them, small ones, some without bounds.
                let x = match bits() >> 60 {
                    0..9 => near + wide(bits()),
                    9 => near + 1e-6 * wide(bits()),
                    10 if k % 8 == 0 => near + 1e-15 * wide(bits()),
                    11 => 1e-8 * wide(bits()),
                    12 => 1e-160 * near * wide(bits()),
                    13 if k % 8 == 1 => f64::from_bits(bits()),
                    14 => 0.0,
                    _ => 3.0 * wide(bits()),
                };
                if bits() >> 63 == 0 { x } else { -x }
            };
            let x = Row(core::array::from_fn::<_, 8, _>(&mut angle));
            vectorised += usize::from(x.0.iter().all(|x| x.abs() < 7.0));
            let (sine, cosine) = x.sincos();
            for ((x, sine), cosine) in x.0.into_iter().zip(sine.0).zip(cosine.0) {
                let exact = libm::sincos(x);
                let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(same(sine, exact.0) && same(cosine, exact.1), "{x}: {sine} {cosine} {exact:?}");
            }
        }
        assert!(vectorised > 100_000, "{vectorised}");
    }

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
