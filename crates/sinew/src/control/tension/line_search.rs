//! The exact maximum of the dual along a direction.

use super::scalar::Scalar;

/// One muscle along a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray<S> {
    /// Tension without limits at step 0, and its limits.
    pub(super) from: S,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// `R_i d`, and its product with the compliance: the change of that tension per unit of the step.
    pub(super) pull: S,
    pub(super) rate: S,
}

/// Where a muscle leaves one limit and reaches the other, and the curvature that it adds between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment<S> {
    enter: S,
    leave: S,
    curvature: S,
}

/// The dual along `lambda + s d`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<S> {
    /// Slope at `s = 0`.
    pub(super) slope: S,
    /// `|tau d|`.
    pub(super) torque: f64,
    /// Curvature of the regularization: `eps |d|^2`.
    pub(super) regularization: S,
}

/// The step where the slope of the dual vanishes, infinite where it never does: no tensions within the limits
/// give the torque then.
///
/// ```text
/// slope(s) = tau d - sum_i pull_i clip(from_i + s rate_i, lower_i, upper_i) - s eps |d|^2
/// ```
///
/// The slope falls, piecewise linear. Breakpoints are visited in their order; curvatures are summed anew on
/// every piece, so that stiff muscles that come and go leave no rounding. `segments` is room for as many as
/// there are rays.
#[inline]
pub(super) fn search<S: Scalar>(
    rays: impl Iterator<Item = Ray<S>>,
    line: &Line<S>,
    rounding: f64,
    segments: &mut [Segment<S>],
) -> S {
    let (mut count, mut scale) = (0, line.torque);
    let infinite = S::from(f64::INFINITY);
    for ray in rays {
        let rising = ray.rate > S::ZERO;
        let (near, far) = if rising { (ray.lower, ray.upper) } else { (ray.upper, ray.lower) };
        scale += ray.pull.rounded().abs() * near.abs().max(far.abs());
        let moves = (ray.rate.rounded() != 0.0) & (ray.lower < ray.upper);
        let inverse = S::from(1.0) / ray.rate;
        let (enter, leave) = ((S::from(near) - ray.from) * inverse, (S::from(far) - ray.from) * inverse);
        segments[count] = Segment { enter, leave, curvature: ray.pull * ray.rate };
        count += usize::from(moves & (leave > S::ZERO));
    }
    let (mut at, mut slope) = (S::ZERO, line.slope);
    loop {
        let (mut next, mut curvature) = (infinite, line.regularization);
        for segment in &segments[..count] {
            let inside = (segment.enter <= at) & (at < segment.leave);
            curvature += if inside { segment.curvature } else { S::ZERO };
            let breakpoint = if segment.enter > at { segment.enter } else { segment.leave };
            next = if (breakpoint > at) & (breakpoint < next) { breakpoint } else { next };
        }
        if next.rounded() == f64::INFINITY {
            return match curvature > S::ZERO {
                true => at + slope / curvature,
                false if at > S::ZERO && slope.rounded() <= 1e3 * rounding * scale => at,
                false => infinite,
            };
        }
        let fall = curvature * (next - at);
        if fall >= slope {
            return at + slope / curvature;
        }
        slope -= fall;
        at = next;
        if slope.rounded() <= 10.0 * rounding * scale {
            return at;
        }
    }
}

/// Room for `muscles` muscles.
pub(super) fn room<S: Scalar>(muscles: usize) -> alloc::vec::Vec<Segment<S>> {
    alloc::vec![Segment { enter: S::ZERO, leave: S::ZERO, curvature: S::ZERO }; muscles + 1]
}

#[cfg(test)]
mod tests {
    use super::{Line, Ray, room, search};

    const MUSCLE: Ray<f64> = Ray { from: -1.0, lower: 0.0, upper: 2.0, rate: 1.0, pull: 1.0 };

    fn best(torque: f64, regularization: f64) -> f64 {
        search([MUSCLE].into_iter(), &Line { slope: torque, torque, regularization }, 1e-14, &mut room(1))
    }

    #[test]
    fn the_slope_vanishes_at_the_step_found() {
        // slope(s) = 1.5 - clip(s - 1, 0, 2)
        assert_eq!(best(1.5, 0.0).to_bits(), 2.5_f64.to_bits());
    }

    #[test]
    fn a_torque_beyond_the_limits_has_no_best_step_without_regularization() {
        assert!(best(2.5, 0.0).is_infinite());
        assert!((best(2.5, 0.125) - 4.0).abs() < 1e-15);
    }

    #[test]
    fn a_torque_at_the_limit_ends_at_the_last_breakpoint() {
        assert_eq!(best(2.0, 0.0).to_bits(), 3.0_f64.to_bits());
    }
}
