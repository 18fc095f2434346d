//! Elementary functions that a compiler can vectorise: straight-line arithmetic, no tables, no branches.

/// Hyperbolic tangent, branch-free.
///
/// ```text
/// |x| -> t = 2 |x| = k ln 2 + r, |r| <= ln(2)/2;   m = exp(t) - 1 = 2^k p(r) + (2^k - 1)
/// tanh x = sign(x) m / (m + 2)
/// ```
///
/// | symbol | argument | unit | domain         | meaning                       |
/// |--------|----------|------|----------------|-------------------------------|
/// | x      | `x`      | 1    | every `f64`    | NaN gives NaN                 |
/// | p(r)   |          | 1    | `abs(r) <= .35`| Taylor polynomial of exp(r)-1 |
///
/// Measured against `libm::tanh` on 400 000 points of `[-25, 25]` and on magnitudes down to 2^-1000:
/// absolute error at most 2.3e-16, relative error at most 4.4 units in the last place.
/// Odd to the bit, never beyond +-1, monotone up to that error. Plain SSE2 suffices
/// (one division, no fused multiply-add, no integer conversion), so every machine gives the same bits.
///
/// # Example
/// ```
/// assert_eq!(sinew::math::tanh(0.0), 0.0);
/// assert_eq!(sinew::math::tanh(f64::NEG_INFINITY), -1.0);
/// assert!((sinew::math::tanh(0.5) - 0.46211715726000975).abs() < 1e-15);
/// ```
#[inline]
#[must_use]
pub fn tanh(x: f64) -> f64 {
    // 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the mantissa.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts; the first has 21 zero low bits, so that k * LN_2_HIGH is exact.
    const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    // Beyond 20 the result is 1 in f64.
    let t = 2.0 * x.abs().clamp(0.0, 20.0);
    let shifted = t * core::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (t - k * LN_2_HIGH) - k * LN_2_LOW;
    let mut p = 1.0 / 479_001_600.0;
    for inverse in [
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
    ] {
        p = p * r + inverse;
    }
    let two_to_k = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    let m = two_to_k * (p * r) + (two_to_k - 1.0);
    (m / (m + 2.0)).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::tanh;

    #[test]
    fn tanh_agrees_with_libm_everywhere() {
        let (mut absolute, mut ulps) = (0.0_f64, 0.0_f64);
        let mut compare = |x: f64| {
            let exact = libm::tanh(x);
            let error = (tanh(x) - exact).abs();
            absolute = absolute.max(error);
            ulps = ulps.max(error / (exact.abs() * f64::EPSILON / 2.0).max(f64::MIN_POSITIVE));
        };
        for i in -200_000..=200_000 {
            compare(f64::from(i) * 1.25e-4);
        }
        for exponent in 1..1000 {
            compare(libm::pow(2.0, -f64::from(exponent)) * 1.234_567);
        }
        assert!(absolute < 4e-16, "{absolute:e}");
        assert!(ulps < 16.0, "{ulps}");
    }

    #[test]
    fn tanh_is_odd_bounded_and_passes_nan_on() {
        for i in 0..100_000 {
            let x = f64::from(i) * 3.0e-4;
            assert_eq!(tanh(-x).to_bits(), (-tanh(x)).to_bits());
            assert!(tanh(x) <= 1.0);
        }
        for x in [f64::MAX, f64::INFINITY] {
            assert_eq!(tanh(x).to_bits(), 1.0_f64.to_bits());
        }
        assert!(tanh(f64::NAN).is_nan());
    }
}
