//! The exact maximum of the dual along a direction.

use super::block::{Muscle, State};
use super::scalar::Scalar;

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
/// slope(s) = tau d - sum_i pull_i clip(unclipped_i + s rate_i, lower_i, upper_i) - s eps |d|^2
/// ```
///
/// The slope falls, piecewise linear. Breakpoints are visited in their order; curvatures are summed anew on
/// every piece, so that stiff muscles that come and go leave no rounding. `segments` is room for as many as
/// there are muscles.
pub(super) fn search<'a, S: Scalar + 'a>(
    muscles: impl Iterator<Item = (&'a State<S>, &'a Muscle)>,
    line: &Line<S>,
    rounding: f64,
    segments: &mut [Segment<S>],
) -> S {
    let (mut count, mut scale) = (0, line.torque);
    let infinite = S::from(f64::INFINITY);
    for (&State { unclipped, pull, rate, .. }, &Muscle { lower, upper, .. }) in muscles {
        let (near, far) = if rate > S::ZERO { (lower, upper) } else { (upper, lower) };
        scale += pull.rounded().abs() * near.abs().max(far.abs());
        let moves = (rate.rounded() != 0.0) & (lower < upper);
        let inverse = S::from(1.0) / rate;
        let [enter, leave] = [near, far].map(|limit| (S::from(limit) - unclipped) * inverse);
        segments[count] = Segment { enter, leave, curvature: pull * rate };
        count += usize::from(moves & (leave > S::ZERO));
    }
    let (mut at, mut slope) = (S::ZERO, line.slope);
    loop {
        let (mut next, mut curvature) = (infinite, line.regularization);
        for segment in &segments[..count] {
            let inside = (segment.enter <= at) & (at < segment.leave);
            curvature = curvature + if inside { segment.curvature } else { S::ZERO };
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
        slope = slope - fall;
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
    use super::{Line, Muscle, State, room, search};

    fn best(torque: f64, regularization: f64) -> f64 {
        let state = State { unclipped: -1.0, rate: 1.0, pull: 1.0, ..State::ZERO };
        let muscle = Muscle { upper: 2.0, ..Muscle::default() };
        search(
            [(&state, &muscle)].into_iter(),
            &Line { slope: torque, torque, regularization },
            1e-14,
            &mut room(1),
        )
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
