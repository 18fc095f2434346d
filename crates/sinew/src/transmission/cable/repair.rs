//! The rare lanes that the implicit step does not solve: tension after slack, and the exact play sweeps.

use super::lane_group::LaneGroup;
use super::travel::{CellView, move_end};

/// Tensions of a cable that was slack before the step: the profile of sliding everywhere with the total
/// stretch.
///
/// Friction without viscous terms; the sum of both motions decides the direction. Returns both ends'
/// tensions.
#[cold]
#[inline(never)]
pub(super) fn retension<const N: usize>(
    lanes: &mut LaneGroup<N>,
    k: usize,
    motor: f64,
    anchor: f64,
) -> (f64, f64) {
    let m = lanes.tension.len();
    let s = if motor + anchor >= 0.0 { 1.0 } else { -1.0 };
    let (mut ratio, mut sum) = (1.0, 0.0);
    for j in 0..m {
        if j > 0 {
            ratio *= tension_ratio(s * lanes.nodes[j - 1].tanh_half.0[k]);
            let x = j as f64 / m as f64;
            lanes.slip[j].0[k] = motor + (anchor - motor) * x;
        }
        lanes.next_tension[j].0[k] = ratio;
        sum += lanes.compliance[j].0[k] * ratio;
    }
    let unit = lanes.stretch.0[k] / sum;
    let mut energy = 0.0;
    for (next, compliance) in lanes.next_tension.iter_mut().zip(&lanes.compliance) {
        next.0[k] *= unit;
        energy += compliance.0[k] * next.0[k] * next.0[k];
    }
    lanes.energy.0[k] = energy;
    (lanes.next_tension[0].0[k], lanes.next_tension[m - 1].0[k])
}

/// Moves the ends one after the other from the tensions before the step, the end that tightens first.
///
/// Strictly passive: each end's tension is that of its own sweep. Drag is left out for this one step.
#[cold]
#[inline(never)]
pub(super) fn sweep_both_ends<const N: usize>(
    lanes: &mut LaneGroup<N>,
    k: usize,
    motor: f64,
    anchor: f64,
) -> (f64, f64) {
    let m = lanes.tension.len();
    for (next, tension) in lanes.next_tension.iter_mut().zip(&lanes.tension) {
        next.0[k] = tension.0[k];
    }
    let (near, far);
    if motor > 0.0 {
        near = sweep_near(lanes, k, motor);
        far = sweep_far(lanes, k, -anchor);
    } else {
        far = sweep_far(lanes, k, -anchor);
        near = sweep_near(lanes, k, motor);
    }
    let mut energy = 0.0;
    for (next, compliance) in lanes.next_tension.iter().zip(&lanes.compliance) {
        energy += compliance.0[k] * next.0[k] * next.0[k];
    }
    lanes.energy.0[k] = energy;
    for slip in &mut lanes.slip {
        slip.0[k] = 0.0;
    }
    (near.unwrap_or(lanes.next_tension[0].0[k]), far.unwrap_or(lanes.next_tension[m - 1].0[k]))
}

/// Moves the drive's end; returns its tension, or none where it does not move.
fn sweep_near<const N: usize>(lanes: &mut LaneGroup<N>, k: usize, distance: f64) -> Option<f64> {
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut ratio = 1.0;
    for j in 0..lanes.next_tension.len() {
        if j > 0 {
            ratio *= tension_ratio(s * lanes.nodes[j - 1].tanh_half.0[k]);
        }
        let (tension, compliance) = (lanes.next_tension[j].0[k], lanes.compliance[j].0[k]);
        lanes.cells_from_end[j] = CellView { tension, compliance, ratio };
    }
    let moved = move_end(&mut lanes.cells_from_end, distance);
    for (next, cell) in lanes.next_tension.iter_mut().zip(&lanes.cells_from_end) {
        next.0[k] = cell.tension;
    }
    (distance != 0.0).then_some(moved)
}

/// Moves the anchor's end away from the motor by `distance`; returns its tension, or none where it does not
/// move.
fn sweep_far<const N: usize>(lanes: &mut LaneGroup<N>, k: usize, distance: f64) -> Option<f64> {
    let m = lanes.next_tension.len();
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut ratio = 1.0;
    for j in (0..m).rev() {
        if j + 1 < m {
            ratio *= tension_ratio(s * lanes.nodes[j].tanh_half.0[k]);
        }
        let (tension, compliance) = (lanes.next_tension[j].0[k], lanes.compliance[j].0[k]);
        lanes.cells_from_end[m - 1 - j] = CellView { tension, compliance, ratio };
    }
    let moved = move_end(&mut lanes.cells_from_end, distance);
    for (next, cell) in lanes.next_tension.iter_mut().zip(lanes.cells_from_end.iter().rev()) {
        next.0[k] = cell.tension;
    }
    (distance != 0.0).then_some(moved)
}

/// `e^(-2 h)` from `tanh h`: tension behind a sliding node over that in front of it, as the step has it.
pub(super) fn tension_ratio(grip: f64) -> f64 {
    (1.0 - grip) / (1.0 + grip)
}

#[cfg(test)]
mod tests {
    use super::super::bare::{Random, law, swept};
    use super::super::lane_group::Row;
    use super::*;
    use alloc::vec::Vec;

    /// Two lanes, of which the second one is repaired.
    fn lanes(compliance: &[f64], half_angle: &[f64], tension: &[f64]) -> LaneGroup<2> {
        let mut lanes = LaneGroup::new(&[law(compliance, half_angle)]);
        for (row, t) in lanes.tension.iter_mut().zip(tension) {
            *row = Row([*t; 2]);
        }
        lanes
    }

    fn lane(rows: &[Row<2>], k: usize) -> Vec<f64> {
        rows.iter().map(|row| row.0[k]).collect()
    }

    fn twice_the_energy(compliance: &[f64], tension: &[f64]) -> f64 {
        compliance.iter().zip(tension).map(|(c, t)| c * t * t).sum()
    }

    #[test]
    fn after_slack_the_cable_slides_everywhere_with_its_whole_stretch() {
        let (compliance, half_angle) = ([2e-4, 1e-4, 4e-4, 3e-4], [0.05, 0.12, 0.08]);
        for (motor, anchor) in [(3e-4, -1e-4), (3e-4, 1e-4), (1e-4, -3e-4), (-1e-4, -3e-4), (-1e-4, 3e-4)] {
            let mut lanes = lanes(&compliance, &half_angle, &[0.0; 4]);
            lanes.stretch = Row([7.0, 2.5e-3]);
            let (near, far) = retension(&mut lanes, 1, motor, anchor);

            // What the cable does on the whole decides the direction.
            let s = (motor + anchor).signum();
            let after = lane(&lanes.next_tension, 1);
            let stretch: f64 = after.iter().zip(&compliance).map(|(t, c)| t * c).sum();
            assert!((stretch - 2.5e-3).abs() < 1e-17, "{stretch}");
            for (pair, h) in after.windows(2).zip(&half_angle) {
                assert!((pair[1] / pair[0] / libm::exp(-2.0 * s * h) - 1.0).abs() < 4e-10, "{after:?}");
            }
            assert!((near - after[0]).abs() < 1e-15 && (far - after[3]).abs() < 1e-15);
            assert!((lanes.energy.0[1] - twice_the_energy(&compliance, &after)).abs() < 1e-16);
            // Every piece of it moves as its place between the ends.
            for (j, slip) in lane(&lanes.slip, 1).iter().enumerate().take(4).skip(1) {
                let x = 0.25 * j as f64;
                assert!((slip - (motor * (1.0 - x) + anchor * x)).abs() < 5e-20, "{slip}");
            }
            let untouched = [&lanes.next_tension, &lanes.slip].into_iter().flat_map(|rows| lane(rows, 0));
            assert!(untouched.chain([lanes.energy.0[0]]).all(|number| number == 0.0));
        }
    }

    #[test]
    fn both_ends_are_swept_one_after_the_other_the_one_that_tightens_first() {
        let mut random = Random(2);
        let mut order_matters = 0;
        for case in 0..200 {
            let (compliance, half_angle) = (random.many(4, 1e-4, 5e-4), random.many(3, 0.01, 0.15));
            let tension = random.many(4, 0.0, 50.0);
            let mut draw = |still: bool| if still { 0.0 } else { random.between(-1e-2, 1e-2) };
            let (motor, anchor) = (draw(case % 5 == 1), draw(case % 5 == 2));
            let mut lanes = lanes(&compliance, &half_angle, &tension);
            lanes.slip.fill(Row([1e-4; 2]));
            let (near, far) = sweep_both_ends(&mut lanes, 1, motor, anchor);

            // Seen from the anchor, everything is in reverse order, and motion away from the motor pulls.
            let reversed = |numbers: &[f64]| -> Vec<f64> { numbers.iter().rev().copied().collect() };
            let near_swept = |from: &[f64]| {
                if motor == 0.0 { from.to_vec() } else { swept(from, &compliance, &half_angle, motor) }
            };
            let far_swept = |from: &[f64]| {
                if anchor == 0.0 {
                    return from.to_vec();
                }
                let (c, h) = (reversed(&compliance), reversed(&half_angle));
                reversed(&swept(&reversed(from), &c, &h, -anchor))
            };
            let near_first = far_swept(&near_swept(&tension));
            let far_first = near_swept(&far_swept(&tension));
            let (exact, pulled, held) = if motor > 0.0 {
                (&near_first, near_swept(&tension)[0], near_first[3])
            } else {
                (&far_first, far_first[0], far_swept(&tension)[3])
            };
            let after = lane(&lanes.next_tension, 1);
            let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off(&after, exact) < 7e-8, "{case} {after:?} {exact:?}");
            order_matters += usize::from(off(&near_first, &far_first) > 1e-2);
            // An end's tension is that of its own sweep, or what the cable has there where it did not move.
            let near_exact = if motor == 0.0 { exact[0] } else { pulled };
            let far_exact = if anchor == 0.0 { exact[3] } else { held };
            assert!((near - near_exact).abs() < 7e-8 && (far - far_exact).abs() < 7e-8, "{case}");

            let energy = twice_the_energy(&compliance, &after);
            assert!((lanes.energy.0[1] - energy).abs() < 4e-16 * (1.0 + energy), "{case}");
            let gained = 0.5 * (energy - twice_the_energy(&compliance, &tension));
            assert!(near * motor - far * anchor - gained > -1e-14, "{case}");
            assert!(lane(&lanes.slip, 1).iter().all(|slip| *slip == 0.0));
            assert!(lane(&lanes.next_tension, 0).iter().all(|tension| *tension == 0.0));
            assert_eq!(lane(&lanes.tension, 1), tension, "the step accepts them, not the sweep");
        }
        assert!(order_matters > 20, "{order_matters}");
    }
}
