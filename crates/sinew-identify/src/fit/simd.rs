//! Arithmetic on SIMD vectors of any width, for f64 and f32.

use pulp::{Simd, bytemuck};

/// `count` rounded up to a multiple of `of`.
pub(super) const fn padded(count: usize, of: usize) -> usize {
    count.div_ceil(of) * of
}

/// f64 or f32, the precision in which products are summed.
pub(super) trait Real: Copy + Send + 'static {
    /// A SIMD vector of them.
    type Vector<S: Simd>: Copy;
    /// Numbers in the widest vector of any machine; rows are padded to it, so that they consist of whole
    /// vectors.
    const WIDEST: usize;
    const ZERO: Self;
    const ONE: Self;
    fn from_f64(value: f64) -> Self;
    fn to_f64(self) -> f64;
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    fn mul<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;
    fn width<S: Simd>() -> usize;
    fn vectors<S: Simd>(slice: &[Self]) -> &[Self::Vector<S>];
    fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [Self::Vector<S>];
}

macro_rules! real {
    ($real:ident, $lanes:ident, $widest:literal, $count:ident, $splat:ident, $add:ident, $mul:ident,
     $mul_add:ident, $vectors:ident, $vectors_mut:ident) => {
        impl Real for $real {
            type Vector<S: Simd> = S::$lanes;
            const WIDEST: usize = $widest;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $real
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$lanes {
                simd.$splat(value)
            }
            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes, c: S::$lanes) -> S::$lanes {
                simd.$mul_add(a, b, c)
            }
            #[inline(always)]
            fn width<S: Simd>() -> usize {
                S::$count
            }
            #[inline(always)]
            fn vectors<S: Simd>(slice: &[Self]) -> &[S::$lanes] {
                S::$vectors(slice).0
            }
            #[inline(always)]
            fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [S::$lanes] {
                S::$vectors_mut(slice).0
            }
        }
    };
}

real!(
    f64,
    f64s,
    8,
    F64_LANES,
    splat_f64s,
    add_f64s,
    mul_f64s,
    mul_add_e_f64s,
    as_simd_f64s,
    as_mut_simd_f64s
);
real!(
    f32,
    f32s,
    16,
    F32_LANES,
    splat_f32s,
    add_f32s,
    mul_f32s,
    mul_add_e_f32s,
    as_simd_f32s,
    as_mut_simd_f32s
);

/// `N` consecutive vectors from `row[at..]`; zeros if the row is too short.
#[inline(always)]
pub(super) fn load<S: Simd, R: Real, const N: usize>(simd: S, row: &[R], at: usize) -> [R::Vector<S>; N] {
    let from = row.get(at..at + N * R::width::<S>()).unwrap_or_default();
    R::vectors::<S>(from).first_chunk::<N>().copied().unwrap_or([R::splat(simd, R::ZERO); N])
}

/// Writes `N` consecutive vectors to `row[at..]`; nothing if the row is too short.
#[inline(always)]
pub(super) fn store<S: Simd, R: Real, const N: usize>(row: &mut [R], at: usize, vectors: [R::Vector<S>; N]) {
    let to = row.get_mut(at..at + N * R::width::<S>()).unwrap_or_default();
    if let Some(to) = R::vectors_mut::<S>(to).first_chunk_mut::<N>() {
        *to = vectors;
    }
}

/// Hyperbolic tangent to 5e-16 absolute.
///
/// ```text
/// t = exp(-2 |x|),  tanh x = sign(x) (1 - t) / (1 + t)
/// exp(y) = 2^k exp(r),  k = round(y / ln 2),  |r| <= ln 2 / 2
/// ```
///
/// `exp(r)` is its Taylor polynomial of degree 13, whose remainder is below 1e-17. The relative error grows
/// as x goes to zero, which is irrelevant in a sum over nodes. All quotients of a call share one division:
/// denominators lie in [1, 2], so their product is harmless for any sensible `N`.
#[inline(always)]
pub(super) fn tanh<S: Simd, const N: usize>(simd: S, x: [S::f64s; N]) -> [S::f64s; N] {
    let one = simd.splat_f64s(1.0);
    let mut numerator = x;
    let mut denominator = x;
    for i in 0..N {
        // `abs_f64s` stays a function call in builds with less optimisation.
        let magnitude = simd.max_f64s(x[i], simd.neg_f64s(x[i]));
        let t = exp_of_minus_twice(simd, magnitude);
        numerator[i] = simd.sub_f64s(one, t);
        denominator[i] = simd.add_f64s(one, t);
    }
    // after[i] = product of the denominators behind i; before = product of those ahead of it.
    let mut after = [one; N];
    for i in (0..N.saturating_sub(1)).rev() {
        after[i] = simd.mul_f64s(after[i + 1], denominator[i + 1]);
    }
    let mut before = simd.div_f64s(one, simd.mul_f64s(after[0], denominator[0]));
    let sign = simd.splat_f64s(-0.0);
    let mut out = x;
    for i in 0..N {
        let quotient = simd.mul_f64s(numerator[i], simd.mul_f64s(before, after[i]));
        out[i] = simd.or_f64s(quotient, simd.and_f64s(sign, x[i]));
        before = simd.mul_f64s(before, denominator[i]);
    }
    out
}

/// `exp(-2 a)` for `a >= 0`; beyond 20 it is 4e-18, below the rounding of 1.
#[inline(always)]
fn exp_of_minus_twice<S: Simd>(simd: S, a: S::f64s) -> S::f64s {
    const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    // Adding this rounds to an integer and leaves the exponent bits of 2^k at the bottom of the word.
    const ROUND: f64 = 6_755_399_441_055_744.0 + 1023.0;
    let of = |c: f64| simd.splat_f64s(c);
    let y = simd.mul_f64s(simd.min_f64s(a, of(20.0)), of(-2.0));
    let rounded = simd.mul_add_e_f64s(y, of(std::f64::consts::LOG2_E), of(ROUND));
    let k = simd.sub_f64s(rounded, of(ROUND));
    let r = simd.mul_add_e_f64s(k, of(-LN_2_HIGH), y);
    let r = simd.mul_add_e_f64s(k, of(-LN_2_LOW), r);
    let mut power = rounded;
    for bits in bytemuck::cast_slice_mut::<S::f64s, u64>(std::slice::from_mut(&mut power)) {
        *bits <<= 52;
    }
    // Pairs of terms first: shorter chains of dependent operations than Horner's.
    let r2 = simd.mul_f64s(r, r);
    let pair =
        |low: usize| simd.mul_add_e_f64s(r, of(INVERSE_FACTORIAL[low + 1]), of(INVERSE_FACTORIAL[low]));
    let mut sum = pair(12);
    for low in [10, 8, 6, 4, 2, 0] {
        sum = simd.mul_add_e_f64s(sum, r2, pair(low));
    }
    simd.mul_f64s(sum, power)
}

const INVERSE_FACTORIAL: [f64; 14] = {
    let mut out = [1.0; 14];
    let mut factorial = 1.0;
    let mut i = 1;
    while i < 14 {
        factorial *= i as f64;
        out[i] = 1.0 / factorial;
        i += 1;
    }
    out
};

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::WithSimd;

    struct Tanh<'a>(&'a mut [f64]);

    impl WithSimd for Tanh<'_> {
        type Output = ();
        fn with_simd<S: Simd>(self, simd: S) {
            for at in (0..self.0.len()).step_by(4 * S::F64_LANES) {
                let out = tanh::<S, 4>(simd, load(simd, self.0, at));
                store::<S, f64, 4>(self.0, at, out);
            }
        }
    }

    #[test]
    fn tanh_agrees_with_the_library_everywhere() {
        let mut x: Vec<f64> = (0..32 * 1024).map(|i| (f64::from(i) - 16_384.0) / 700.0).collect();
        x[..4].copy_from_slice(&[1e300, -1e300, f64::MIN_POSITIVE, -700.0]);
        let expected: Vec<f64> = x.iter().map(|x| x.tanh()).collect();
        let mut scalar = x.clone();
        pulp::Arch::new().dispatch(Tanh(&mut x));
        Tanh(&mut scalar).with_simd(pulp::Scalar);
        for got in [x, scalar] {
            let worst = got.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The library's own last bit depends on the processor.
            assert!(worst < 1e-15, "{worst:e}");
        }
    }
}
