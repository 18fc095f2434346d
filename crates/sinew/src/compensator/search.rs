//! The search for the command: bisection from where the near side is.

use super::reach::Reach;

/// What is sought, and how closely.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Desired response.
    pub(super) desired: f64,
    /// Error of the response that counts as attained.
    pub(super) tolerance: f64,
    /// Maximum of halvings of the reach.
    pub(super) halvings: u32,
    /// Whether a response that is the same at the end of the reach is a dead band to be crossed, and not one
    /// that the argument has no effect on.
    pub(super) crosses: bool,
}

/// The first place from the start of the reach, in the direction in which the response comes closer to what
/// is desired, at which it is attained or passed; the end of the reach where it is not.
///
/// `rising` is whether the response rises with its argument as a whole, `at_start` its value at the start.
/// Evaluates `response` at most `halvings + 1` times. Monotone in `desired`, whatever the response: for two
/// goals the same places are tried until the lower one turns back where the higher one goes on.
pub(super) fn search(
    reach: &Reach,
    rising: bool,
    at_start: f64,
    goal: Goal,
    response: &mut impl FnMut(f64) -> f64,
) -> f64 {
    let Goal { desired, tolerance, halvings, crosses } = goal;
    let attained = |value: f64| (value - desired).abs() <= tolerance;
    if attained(at_start) {
        return reach.start;
    }
    let more = desired > at_start;
    let passed = |value: f64| if more { value >= desired } else { value <= desired };
    let mut beyond = if more == rising { reach.high } else { reach.low };
    let mut before = reach.start;
    if same(beyond, before) {
        return before;
    }
    let at_end = response(beyond);
    if same(at_end, at_start) && !crosses {
        return before;
    }
    if attained(at_end) || !passed(at_end) {
        return beyond;
    }
    for _ in 0..halvings {
        let middle = 0.5 * (before + beyond);
        if same(middle, before) || same(middle, beyond) {
            break;
        }
        let value = response(middle);
        if attained(value) {
            return middle;
        }
        if passed(value) {
            beyond = middle;
        } else {
            before = middle;
        }
    }
    beyond
}

/// Whether two numbers are bit-identical.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const REACH: Reach = Reach { low: -4.0, high: 6.0, start: 1.0 };

    fn goal(desired: f64) -> Goal {
        Goal { desired, tolerance: 1e-9, halvings: 60, crosses: true }
    }

    /// Found for a response, with the number of evaluations.
    fn found(rising: bool, desired: f64, mut response: impl FnMut(f64) -> f64) -> (f64, u32) {
        let (at_start, mut count) = (response(REACH.start), 0);
        let place = search(&REACH, rising, at_start, goal(desired), &mut |u| {
            count += 1;
            response(u)
        });
        (place, count)
    }

    #[test]
    fn a_dead_band_is_held_where_it_is_right_and_crossed_to_its_edge_where_it_is_not() {
        let play = |u: f64| if u > 3.0 { u - 3.0 } else { (u + 2.0).min(0.0) };
        assert_eq!(found(true, 0.0, play), (1.0, 0));
        assert!((found(true, 0.5, play).0 - 3.5).abs() < 1e-8);
        assert!((found(true, -0.5, play).0 + 2.5).abs() < 1e-8);
        // Out of reach on either side.
        assert_eq!(found(true, 7.0, play), (6.0, 1));
        assert_eq!(found(true, -7.0, play), (-4.0, 1));
        // A response that falls.
        assert!((found(false, -0.5, |u| -play(u)).0 - 3.5).abs() < 1e-8);
    }

    #[test]
    fn an_argument_without_effect_is_left_unless_a_dead_band_is_to_be_crossed() {
        for (crosses, place) in [(true, 6.0), (false, 1.0)] {
            let goal = Goal { crosses, ..goal(3.0) };
            assert!(same(search(&REACH, true, 2.0, goal, &mut |_| 2.0), place));
        }
    }

    proptest! {
        #[test]
        fn it_is_monotone_in_what_is_desired_and_bounded_for_any_response(
            waves in proptest::collection::vec((-3.0..3.0_f64, 0.1..9.0_f64), 1..6),
            slope in 0.0..1.0_f64, step in -2.0..2.0_f64, jump in -4.0..6.0_f64,
            mut goals in proptest::array::uniform8(-9.0..9.0_f64), rising: bool,
        ) {
            goals.sort_by(f64::total_cmp);
            let response = |u: f64| {
                let waves: f64 = waves.iter().map(|(a, w)| a * libm::sin(w * u)).sum();
                waves + if u > jump { step } else { 0.0 } + if rising { slope * u } else { -slope * u }
            };
            let places = goals.map(|desired| found(rising, desired, response));
            for pair in places.windows(2) {
                let ordered = if rising { pair[0].0 <= pair[1].0 } else { pair[0].0 >= pair[1].0 };
                prop_assert!(ordered, "{places:?}");
            }
            prop_assert!(places.iter().all(|(place, count)| *count <= 61 && (-4.0..=6.0).contains(place)));
        }
    }
}
