//! The best step along a direction of the dual, exactly.

/// How one muscle meets a direction: where it leaves one limit and reaches the other, and what it adds between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    /// Step length.
    at: f64,
    /// What the curvature gains there.
    curvature: f64,
}

/// Slope relative to what it is made of that counts as none.
const ROUNDING: f64 = 1e-13;

/// Slope beyond the last event that tells a torque out of reach.
pub(super) const OUTSIDE: f64 = 1e-11;

/// One muscle along a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    /// Tension without limits at step 0, and its limits.
    pub(super) from: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// Change of that tension per step.
    pub(super) rate: f64,
    /// Change of the muscle's dual argument per step: `rate` times the weight.
    pub(super) pull: f64,
}

/// The step where the slope of the dual vanishes.
///
/// ```text
/// slope(s) = tau d - sum_i pull_i clip(from_i + s rate_i, lower_i, upper_i)      falls, piecewise linear
/// ```
///
/// `slope` is that at step 0, `torque` is `tau d`; with `softness`, it falls by that much more per step. It is known to
/// vanish before `until`; where that is infinite and it never does, no tension within the limits gives the torque, and
/// the step is infinite. Events are walked in their order; `events` is the room for them.
#[inline(always)]
pub(super) fn search(
    rays: impl Iterator<Item = Ray>,
    slope: f64,
    torque: f64,
    softness: f64,
    until: f64,
    events: &mut [Event],
) -> f64 {
    let (mut count, mut curvature, mut scale) = (0, Sum::default(), torque.abs());
    curvature.add(softness);
    for ray in rays {
        // Without a branch: where the limits of a muscle lie is hard to foretell.
        let (near, far) = if ray.rate > 0.0 { (ray.lower, ray.upper) } else { (ray.upper, ray.lower) };
        let most = if near.abs() > far.abs() { near.abs() } else { far.abs() };
        scale += ray.pull.abs() * most;
        let inverse = 1.0 / ray.rate;
        let (enter, leave) = ((near - ray.from) * inverse, (far - ray.from) * inverse);
        let gain = ray.pull * ray.rate;
        let moves = (ray.rate != 0.0) & (ray.lower < ray.upper);
        let leaves = moves & (leave > 0.0);
        events[count] = Event { at: leave, curvature: -gain };
        count += usize::from(leaves & (leave < until));
        events[count] = Event { at: enter, curvature: gain };
        count += usize::from(moves & (enter > 0.0) & (enter < until));
        curvature.add(if leaves & (enter <= 0.0) { gain } else { 0.0 });
    }
    let rounding = ROUNDING * scale;
    let (mut at, mut slope) = (0.0, slope);
    while let Some(event) = take_next(events, &mut count) {
        let fall = curvature.value() * (event.at - at);
        if fall >= slope {
            return at + slope / curvature.value();
        }
        slope -= fall;
        at = event.at;
        curvature.add(event.curvature);
        if slope <= rounding {
            return at;
        }
    }
    if until < f64::INFINITY {
        return until.min(at + slope / curvature.value());
    }
    if softness > 0.0 {
        return at + slope / curvature.value().max(softness);
    }
    if at > 0.0 && slope <= OUTSIDE * scale { at } else { f64::INFINITY }
}

/// Takes the next event out. Few of them lie before the best step: looking for each is faster than sorting all.
#[inline(always)]
fn take_next(events: &mut [Event], count: &mut usize) -> Option<Event> {
    let (mut next, mut at) = (0, f64::INFINITY);
    for (k, event) in events[..*count].iter().enumerate() {
        next = if event.at < at { k } else { next };
        at = if event.at < at { event.at } else { at };
    }
    *count = count.checked_sub(1)?;
    events[..=*count].swap(next, *count);
    Some(events[*count])
}

/// A sum that keeps what rounding takes from it: what a stiff muscle adds and takes again leaves a soft one's share.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, term: f64) {
        let sum = self.high + term;
        let part = sum - self.high;
        self.low += (self.high - (sum - part)) + (term - part);
        self.high = sum;
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.high + self.low
    }
}

/// Room for `muscles` muscles.
pub(super) fn room(muscles: usize) -> alloc::vec::Vec<Event> {
    alloc::vec![Event { at: 0.0, curvature: 0.0 }; 2 * muscles + 2]
}

#[cfg(test)]
mod tests {
    use super::{Ray, room, search};

    const MUSCLE: Ray = Ray { from: -1.0, lower: 0.0, upper: 2.0, rate: 1.0, pull: 1.0 };

    fn best(torque: f64, until: f64) -> f64 {
        search([MUSCLE].into_iter(), torque, torque, 0.0, until, &mut room(1))
    }

    #[test]
    fn the_slope_vanishes_at_the_step_found() {
        // slope(s) = 1.5 - clip(s - 1, 0, 2)
        assert_eq!(best(1.5, f64::INFINITY).to_bits(), 2.5_f64.to_bits());
    }

    #[test]
    fn events_beyond_a_step_where_the_dual_falls_do_not_matter() {
        assert_eq!(best(1.5, 2.75).to_bits(), 2.5_f64.to_bits());
    }

    #[test]
    fn a_torque_beyond_the_limits_has_no_best_step() {
        assert!(best(2.5, f64::INFINITY).is_infinite());
    }

    #[test]
    fn a_torque_at_the_limit_ends_at_the_last_event() {
        assert_eq!(best(2.0, f64::INFINITY).to_bits(), 3.0_f64.to_bits());
    }
}
