//! The elementary functions of the step, without branches, so that they vectorise.

/// Largest argument of [`tanh_series`]; drag beyond it stays what it is there.
const SERIES_END: f64 = 0.5;

/// `tanh x` as an odd polynomial, `x` clipped to +-0.5: relative error 2e-9 up to 0.15, 2e-5 at 0.4.
#[inline(always)]
pub(super) fn tanh_series(x: f64) -> f64 {
    let x = at_most(at_least(x, -SERIES_END), SERIES_END);
    let z = x * x;
    x * (1.0 + z * (-1.0 / 3.0 + z * (2.0 / 15.0 + z * (-17.0 / 315.0))))
}

/// The larger one as one machine instruction, which `f64::max` is not, because of its rule for NaN.
#[inline(always)]
pub(super) fn at_least(x: f64, least: f64) -> f64 {
    if x > least { x } else { least }
}

#[inline(always)]
fn at_most(x: f64, most: f64) -> f64 {
    if x < most { x } else { most }
}
