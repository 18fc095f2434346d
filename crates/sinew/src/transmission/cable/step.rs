//! One implicit time step: a Newton step on the balance of every node, solved as a tridiagonal system.
//!
//! With the correction `x_i` of the displacement `w_i` of node `i`, the linearised balance is
//!
//! ```text
//! -sub_i x_(i-1) + main_i x_i - super_i x_(i+1) = rhs_i,    i = 1 .. M-1,    x_0 = x_M = 0
//! sub_i = (1 - tau_i) k_(i-1),   super_i = (1 + tau_i) k_i,   main_i = sub_i + super_i + S_i d tau_i/d w_i
//! rhs_i = T_(i-1) - T_i - tau_i (T_(i-1) + T_i)
//! ```
//!
//! where `k_j = 1/c_j`, `tau_i = tanh(s_i h_i + g_i v_i)`; a node that sticks has the row `x_i = -w_i`. The
//! Thomas algorithm solves it: forward elimination leaves `x_i = rhs'_i + super'_i x_(i+1)`, back
//! substitution finds `x`. The matrix is diagonally dominant, so no pivoting is needed.

use super::elementary::{at_least, tanh_series};
use super::lane_group::{Ends, LaneGroup, Motion, Row};
use super::repair::{retension, sweep_both_ends};

/// Friction bound, N, below which a node cannot stick: no wrap, or no tension.
const NO_FRICTION: f64 = 1e-12;
/// Work, J, that friction at a node may do on the cable by rounding; beyond it the node is held.
const FRICTION_WORK: f64 = 1e-10;
/// Energy, J, that a step may create by rounding.
const ROUNDING: f64 = 1e-12;

/// Moves all lanes by one step of `interval` seconds.
#[inline(always)]
pub(super) fn advance<const N: usize>(
    lanes: &mut LaneGroup<N>,
    interval: f64,
    motion: &Motion<N>,
    ends: &mut Ends<N>,
) {
    let before = lanes.stretch;
    let mut stretch = before;
    for k in 0..N {
        stretch.0[k] += motion.motor.0[k] - motion.anchor.0[k];
    }
    lanes.stretch = stretch;
    lanes.slip[0] = motion.motor;
    lanes.slip[lanes.tension.len()] = motion.anchor;
    if !lanes.memory.is_empty() {
        update_friction(lanes, interval);
    }
    let rate = 1.0 / interval;
    for _ in 1..lanes.iterations {
        eliminate(lanes, rate, motion);
        correct_displacements(lanes);
    }
    eliminate(lanes, rate, motion);
    let (scale, energy) = substitute_back(lanes);
    enforce_passivity(lanes, motion, before, scale, energy, ends);
}

/// Friction coefficients from the lagged speed of every node.
#[inline(always)]
fn update_friction<const N: usize>(lanes: &mut LaneGroup<N>, interval: f64) {
    let Some(law) = lanes.weakening else { return };
    for (i, (memory, node)) in lanes.memory.iter_mut().zip(&mut lanes.nodes).enumerate() {
        let (friction, loss, mut z, w) = (memory.friction, memory.loss, memory.speed, lanes.slip[i + 1]);
        let (mut half_angle, mut tanh_half) = (Row::<N>::ZERO, Row::<N>::ZERO);
        let factors = law.factors(&z);
        for k in 0..N {
            z.0[k] += interval / (law.lag.0[k] + interval) * (w.0[k].abs() / interval - z.0[k]);
            half_angle.0[k] = friction.0[k] * factors.0[k] + loss.0[k];
            tanh_half.0[k] = tanh_series(half_angle.0[k]);
        }
        (memory.speed, node.half_angle, node.tanh_half) = (z, half_angle, tanh_half);
    }
}

/// Forward elimination: each row is formed at the displacements of the last step and eliminated at once.
#[inline(always)]
fn eliminate<const N: usize>(lanes: &mut LaneGroup<N>, rate: f64, motion: &Motion<N>) {
    let m = lanes.tension.len();
    let (tension, stiffness) = (&lanes.tension[..m], &lanes.stiffness[..m]);
    let (nodes, slip) = (&lanes.nodes[..m - 1], &lanes.slip[..=m]);
    let (superdiagonal, right_hand_side) = (&mut lanes.superdiagonal[..m], &mut lanes.right_hand_side[..m]);
    let (fade, drag_factor) = (lanes.fade, lanes.drag_factor);
    // `super'` and `rhs'` of the row before.
    let (mut sup_done, mut rhs_done) = (Row::<N>::ZERO, Row::<N>::ZERO);
    for i in 0..m - 1 {
        let node = &nodes[i];
        for k in 0..N {
            let (kl, kr) = (stiffness[i].0[k], stiffness[i + 1].0[k]);
            let w = slip[i + 1].0[k];
            let left = tension[i].0[k] + (slip[i].0[k] - w) * kl;
            let right = tension[i + 1].0[k] + (w - slip[i + 2].0[k]) * kr;
            let both = left + right;
            let sum = at_least(both, 0.0);
            let difference = left - right;
            // Sliding direction: the difference of tensions that would hold the node at rest, against the
            // friction bound.
            let bound = sum * node.tanh_half.0[k];
            let trial = difference + (kl + kr) * w;
            let driven = if motion.motor.0[k] + motion.anchor.0[k] >= 0.0 { 1.0 } else { -1.0 };
            let sliding = if trial > bound {
                1.0
            } else if trial < -bound {
                -1.0
            } else {
                0.0
            };
            let sign = if bound <= NO_FRICTION { driven } else { sliding };
            // Friction of a sliding node, and its slope in the displacement.
            let drag = node.drag.0[k] * drag_factor.0[k];
            let resistance = (node.viscous.0[k] + drag / (sum + fade.0[k])) * rate;
            let tau = tanh_series(sign * node.half_angle.0[k] + resistance * w);
            let (sub, sup) = ((1.0 - tau) * kl, (1.0 + tau) * kr);
            let main = sub + sup + sum * (1.0 - tau * tau) * resistance;
            let rhs = difference - tau * both;
            let sticks = sign == 0.0;
            let sub = if sticks { 0.0 } else { sub };
            let sup = if sticks { 0.0 } else { sup };
            let main = if sticks { 1.0 } else { main };
            let rhs = if sticks { -w } else { rhs };
            let inverse = 1.0 / (main - sub * sup_done.0[k]);
            rhs_done.0[k] = (rhs + sub * rhs_done.0[k]) * inverse;
            sup_done.0[k] = sup * inverse;
        }
        superdiagonal[i + 1] = sup_done;
        right_hand_side[i + 1] = rhs_done;
    }
}

/// Back substitution of a Newton step that is not the last one: displacements alone.
#[inline(always)]
fn correct_displacements<const N: usize>(lanes: &mut LaneGroup<N>) {
    let m = lanes.tension.len();
    let (superdiagonal, right_hand_side) = (&lanes.superdiagonal[..m], &lanes.right_hand_side[..m]);
    let slip = &mut lanes.slip[..m];
    let mut x = Row::<N>::ZERO;
    for i in (1..m).rev() {
        let (sup, rhs, mut w) = (superdiagonal[i], right_hand_side[i], slip[i]);
        for k in 0..N {
            x.0[k] = rhs.0[k] + sup.0[k] * x.0[k];
            w.0[k] += x.0[k];
        }
        slip[i] = w;
    }
}

/// Back substitution of the last Newton step: displacements, the check that no friction force does work on
/// the cable, and tensions before scaling. Returns the scale that makes the total stretch exact, and twice
/// the elastic energy after it.
#[inline(always)]
fn substitute_back<const N: usize>(lanes: &mut LaneGroup<N>) -> (Row<N>, Row<N>) {
    let m = lanes.tension.len();
    let (tension, stiffness) = (&lanes.tension[..m], &lanes.stiffness[..m]);
    let (compliance, next) = (&lanes.compliance[..m], &mut lanes.next_tension[..m]);
    let (superdiagonal, right_hand_side) = (&lanes.superdiagonal[..m], &lanes.right_hand_side[..m]);
    let slip = &mut lanes.slip[..=m];
    let (mut sum, mut energy) = (Row::<N>::ZERO, Row::<N>::ZERO);
    // Node `j` lies left of cell `j`; node 0 is the winch, whose row is zero. At the node in hand: its
    // correction, its displacement as solved; the displacement of the next node as accepted; the tension of
    // the cell between them as solved.
    let mut x = right_hand_side[m - 1];
    let (mut solved, mut beyond, mut right) = (slip[m - 1], slip[m], Row::<N>::ZERO);
    for k in 0..N {
        solved.0[k] += x.0[k];
        right.0[k] = tension[m - 1].0[k] + (solved.0[k] - beyond.0[k]) * stiffness[m - 1].0[k];
    }
    for j in (0..m - 1).rev() {
        let (sup, rhs, w) = (superdiagonal[j], right_hand_side[j], slip[j]);
        let (t, stiff) = (tension[j], stiffness[j]);
        let (t_beyond, stiff_beyond, c_beyond) = (tension[j + 1], stiffness[j + 1], compliance[j + 1]);
        let (mut t_next, mut accepted) = (Row::<N>::ZERO, Row::<N>::ZERO);
        for k in 0..N {
            x.0[k] = rhs.0[k] + sup.0[k] * x.0[k];
            let w = w.0[k] + x.0[k];
            let left = t.0[k] + (w - solved.0[k]) * stiff.0[k];
            // A node whose friction would do work on the cable is held.
            let gains = (left - right.0[k]) * solved.0[k] < -FRICTION_WORK;
            accepted.0[k] = if gains { 0.0 } else { solved.0[k] };
            let t = at_least(t_beyond.0[k] + (accepted.0[k] - beyond.0[k]) * stiff_beyond.0[k], 0.0);
            t_next.0[k] = t;
            sum.0[k] += c_beyond.0[k] * t;
            energy.0[k] += c_beyond.0[k] * t * t;
            beyond.0[k] = accepted.0[k];
            solved.0[k] = w;
            right.0[k] = left;
        }
        next[j + 1] = t_next;
        slip[j + 1] = accepted;
    }
    let (t, w, stiff, c) = (tension[0], slip[0], stiffness[0], compliance[0]);
    let (mut first, mut scale) = (Row::<N>::ZERO, Row::<N>::ZERO);
    for k in 0..N {
        let t = at_least(t.0[k] + (w.0[k] - beyond.0[k]) * stiff.0[k], 0.0);
        first.0[k] = t;
        sum.0[k] += c.0[k] * t;
        energy.0[k] += c.0[k] * t * t;
        let stretch = lanes.stretch.0[k];
        scale.0[k] = if stretch > 0.0 && sum.0[k] > 0.0 { stretch / sum.0[k] } else { 0.0 };
        energy.0[k] *= scale.0[k] * scale.0[k];
    }
    next[0] = first;
    (scale, energy)
}

/// Accepts lanes whose step created no energy; the others, and those that were slack, take the exact path of
/// `repair`.
#[inline(always)]
fn enforce_passivity<const N: usize>(
    lanes: &mut LaneGroup<N>,
    motion: &Motion<N>,
    before: Row<N>,
    mut scale: Row<N>,
    energy: Row<N>,
    ends: &mut Ends<N>,
) {
    let m = lanes.tension.len();
    let (old, first, last, after) =
        (lanes.energy, lanes.next_tension[0], lanes.next_tension[m - 1], lanes.stretch);
    let (mut near, mut far, mut dissipated) = (Row::<N>::ZERO, Row::<N>::ZERO, Row::<N>::ZERO);
    // 1 where a lane was slack and is not any more, or created energy.
    let mut repair = Row::<N>::ZERO;
    for k in 0..N {
        near.0[k] = first.0[k] * scale.0[k];
        far.0[k] = last.0[k] * scale.0[k];
        let work = near.0[k] * motion.motor.0[k] - far.0[k] * motion.anchor.0[k];
        dissipated.0[k] = work - 0.5 * (energy.0[k] - old.0[k]);
        let retensions = (before.0[k] <= 0.0) & (after.0[k] > 0.0);
        repair.0[k] = if retensions | (dissipated.0[k] < -ROUNDING) { 1.0 } else { 0.0 };
    }
    *ends = Ends { near, far, dissipated };
    lanes.energy = energy;
    if repair.0.iter().sum::<f64>() > 0.0 {
        for k in (0..N).filter(|k| repair.0[*k] > 0.0) {
            let (motor, anchor) = (motion.motor.0[k], motion.anchor.0[k]);
            let (near, far) = if before.0[k] <= 0.0 {
                retension(lanes, k, motor, anchor)
            } else {
                sweep_both_ends(lanes, k, motor, anchor)
            };
            scale.0[k] = 1.0;
            ends.near.0[k] = near;
            ends.far.0[k] = far;
            ends.dissipated.0[k] = near * motor - far * anchor - 0.5 * (lanes.energy.0[k] - old.0[k]);
        }
    }
    for (tension, next) in lanes.tension.iter_mut().zip(&lanes.next_tension) {
        let mut scaled = Row::<N>::ZERO;
        for k in 0..N {
            scaled.0[k] = next.0[k] * scale.0[k];
        }
        *tension = scaled;
    }
    reset_slip_where_slack(lanes);
}

/// A slack cable has no displacements from which the next step could be linearised.
#[inline(always)]
fn reset_slip_where_slack<const N: usize>(lanes: &mut LaneGroup<N>) {
    if lanes.stretch.0.iter().any(|stretch| *stretch <= 0.0) {
        for slip in &mut lanes.slip {
            for k in 0..N {
                slip.0[k] = if lanes.stretch.0[k] <= 0.0 { 0.0 } else { slip.0[k] };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bare::{Random, law, swept};
    use super::super::weakening::{Weakening, WeakeningForm};
    use super::*;
    use crate::transmission::Sliding;
    use alloc::vec;
    use alloc::vec::Vec;

    const COMPLIANCE: [f64; 5] = [2e-4, 1e-4, 5e-4, 3e-4, 2e-4];
    const HALF_ANGLE: [f64; 4] = [0.03, 0.12, 0.08, 0.05];

    fn lane<const N: usize>(rows: &[Row<N>], k: usize) -> Vec<f64> {
        rows.iter().map(|row| row.0[k]).collect()
    }

    fn twice_the_energy(compliance: &[f64], tension: &[f64]) -> f64 {
        compliance.iter().zip(tension).map(|(c, t)| c * t * t).sum()
    }

    fn no_ends<const N: usize>() -> Ends<N> {
        Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO }
    }

    /// Gaussian elimination of a small dense system, pivoted.
    fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
        let n = rows.len();
        for column in 0..n {
            let pivot = (column..n).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
            rows.swap(column, pivot.unwrap());
            let row = rows[column].clone();
            for (i, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != column) {
                let factor = other[column] / row[column];
                assert!(factor.is_finite(), "row {i}");
                other.iter_mut().zip(&row).for_each(|(a, b)| *a -= factor * b);
            }
        }
        rows.iter().enumerate().map(|(i, row)| row[n] / row[i]).collect()
    }

    #[test]
    fn a_newton_step_solves_the_balance_as_the_module_writes_it_down() {
        const M: usize = 5;
        let (mut random, interval) = (Random(3), 1e-3);
        let (mut stuck, mut forth, mut back, mut slack) = (0, 0, 0, 0);
        for case in 0..300 {
            let (compliance, half_angle) = (random.many(M, 1e-4, 5e-4), random.many(M - 1, 0.005, 0.1));
            let mut lanes = LaneGroup::<1>::new(&[law(&compliance, &half_angle)]);
            for node in &mut lanes.nodes {
                (node.viscous.0[0], node.drag.0[0]) = (random.between(0.0, 0.1), random.between(0.0, 0.5));
            }
            lanes.drag_factor.0[0] = random.between(0.2, 2.0);
            // Every fourth cable is nearly slack.
            let largest = if case % 4 == 0 { 0.5 } else { 30.0 };
            for tension in &mut lanes.tension {
                tension.0[0] = random.between(0.0, largest);
            }
            for slip in &mut lanes.slip {
                slip.0[0] = random.between(-3e-4, 3e-4);
            }
            let (w, t) = (lane(&lanes.slip, 0), lane(&lanes.tension, 0));
            let motion = Motion { motor: Row([w[0]]), anchor: Row([w[M]]) };
            eliminate(&mut lanes, 1.0 / interval, &motion);
            correct_displacements(&mut lanes);

            let mut rows = vec![vec![0.0; M]; M - 1];
            for (i, row) in (1..M).zip(&mut rows) {
                let (h, node) = (half_angle[i - 1], &lanes.nodes[i - 1]);
                let (kl, kr) = (1.0 / compliance[i - 1], 1.0 / compliance[i]);
                let (left, right) = (t[i - 1] + kl * (w[i - 1] - w[i]), t[i] + kr * (w[i] - w[i + 1]));
                let sum = (left + right).max(0.0);
                // Tensions beside the node if it did not move in this step.
                let held = (t[i - 1] + kl * w[i - 1]) - (t[i] - kr * w[i + 1]);
                let grip = sum * libm::tanh(h);
                let s = if sum == 0.0 {
                    slack += 1;
                    (w[0] + w[M]).signum()
                } else if held.abs() <= grip {
                    stuck += 1;
                    row[i - 1] = 1.0;
                    row[M - 1] = -w[i];
                    continue;
                } else {
                    *(if held > 0.0 { &mut forth } else { &mut back }) += 1;
                    held.signum()
                };
                let fading = 2.0 * 5.0;
                let g = node.viscous.0[0] + node.drag.0[0] * lanes.drag_factor.0[0] / (sum + fading);
                let tau = libm::tanh(s * h + g * w[i] / interval);
                let slope = (1.0 - tau * tau) * g / interval;
                let (sub, sup) = ((1.0 - tau) * kl, (1.0 + tau) * kr);
                if i > 1 {
                    row[i - 2] = -sub;
                }
                row[i - 1] = sub + sup + sum * slope;
                if i < M - 1 {
                    row[i] = -sup;
                }
                row[M - 1] = left - right - tau * (left + right);
            }
            let corrections = solved(rows);
            let after = lane(&lanes.slip, 0);
            for i in 1..M {
                let off = after[i] - (w[i] + corrections[i - 1]);
                assert!(off.abs() < 1e-12, "{case} {i}: {off}");
            }
            assert!((after[0] - w[0]).abs() + (after[M] - w[M]).abs() == 0.0, "the ends are given");
        }
        assert!(stuck > 50 && forth > 200 && back > 200 && slack > 50, "{stuck} {forth} {back} {slack}");
    }

    #[test]
    fn newton_steps_to_the_end_find_the_tensions_of_the_exact_sweep() {
        let mut random = Random(4);
        let mut reversals = 0;
        for case in 0..60 {
            let mut lanes = LaneGroup::<1>::new(&[law(&COMPLIANCE, &HALF_ANGLE)]);
            lanes.iterations = 30;
            lanes.settle(0, 40.0, if case % 2 == 0 { Sliding::TowardMotor } else { Sliding::AwayFromMotor });
            let mut last = 0.0;
            for _ in 0..6 {
                let motor = random.between(-1e-3, 1e-3);
                let before = lane(&lanes.tension, 0);
                let mut ends = no_ends();
                advance(&mut lanes, 1e-3, &Motion { motor: Row([motor]), anchor: Row::ZERO }, &mut ends);
                let exact = swept(&before, &COMPLIANCE, &HALF_ANGLE, motor);
                for (t, exact) in lane(&lanes.tension, 0).iter().zip(&exact) {
                    assert!((t - exact).abs() < 2e-8, "{case} {t} {exact}");
                }
                reversals += usize::from(motor * last < 0.0);
                last = motor;
            }
        }
        assert!(reversals > 100);
    }

    #[test]
    fn a_node_whose_friction_would_push_the_cable_is_held() {
        // The solution that is handed over moves the first node by `x`, the second one not at all.
        for (tensions, x, held) in [
            ([20.0, 10.0, 10.0], -2e-4, true),
            ([10.0, 20.0, 20.0], 2e-4, true),
            ([20.0, 10.0, 10.0], 2e-4, false),
            ([10.0, 20.0, 20.0], -2e-4, false),
        ] {
            let mut lanes = LaneGroup::<1>::new(&[law(&[1e-4; 3], &[0.1; 2])]);
            for (row, t) in lanes.tension.iter_mut().zip(tensions) {
                row.0[0] = t;
            }
            lanes.update_stretch_and_energy(0);
            lanes.right_hand_side[1] = Row([x]);
            let (scale, energy) = substitute_back(&mut lanes);
            let moved = if held { 0.0 } else { x };
            let exact = [tensions[0] - moved / 1e-4, tensions[1] + moved / 1e-4, tensions[2]];
            for (t, exact) in lane(&lanes.next_tension, 0).iter().zip(exact) {
                assert!((t - exact).abs() < 1e-12, "{x} {t} {exact}");
            }
            assert!((lanes.slip[1].0[0] - moved).abs() < 1e-18 && lanes.slip[2].0[0] == 0.0);
            assert!((scale.0[0] - 1.0).abs() < 4e-16);
            assert!((energy.0[0] - twice_the_energy(&[1e-4; 3], &exact)).abs() < 1e-16);
        }
    }

    /// Lanes at the end of a step whose tensions before it were `old` and come out as `new`.
    fn ending<const N: usize>(old: &[f64; 5], new: [[f64; 5]; N]) -> (LaneGroup<N>, Row<N>) {
        let mut lanes = LaneGroup::<N>::new(&[law(&COMPLIANCE, &HALF_ANGLE)]);
        lanes.slip.fill(Row([1e-5; N]));
        let mut energy = Row::ZERO;
        for (k, new) in new.iter().enumerate() {
            for j in 0..5 {
                (lanes.tension[j].0[k], lanes.next_tension[j].0[k]) = (old[j], new[j]);
            }
            lanes.update_stretch_and_energy(k);
            energy.0[k] = twice_the_energy(&COMPLIANCE, new);
        }
        (lanes, energy)
    }

    #[test]
    fn a_step_that_created_energy_is_swept_anew_and_its_neighbour_stands() {
        let old = [30.0, 28.0, 25.0, 22.0, 20.0];
        let new = [33.0, 29.0, 25.5, 22.0, 21.0];
        let (mut lanes, energy) = ending(&old, [new; 2]);
        let before = lanes.stretch;
        // The first lane is pulled far enough to do the work, the second one yields and cannot have gained
        // tension.
        let motion = Motion { motor: Row([3e-3, -1e-3]), anchor: Row([5e-4, -4e-4]) };
        for k in 0..2 {
            lanes.stretch.0[k] += motion.motor.0[k] - motion.anchor.0[k];
        }
        let mut ends = no_ends();
        enforce_passivity(&mut lanes, &motion, before, Row([1.01, 1.0]), energy, &mut ends);

        let scaled: Vec<f64> = new.iter().map(|t| 1.01 * t).collect();
        assert!(lane(&lanes.tension, 0).iter().zip(&scaled).all(|(a, b)| (a - b).abs() < 1e-13));
        assert!((ends.near.0[0] - scaled[0]).abs() + (ends.far.0[0] - scaled[4]).abs() < 1e-13);
        // What was handed over as the energy counts, whatever its scale.
        let gained = 0.5 * (energy.0[0] - twice_the_energy(&COMPLIANCE, &old));
        let lost = scaled[0] * 3e-3 - scaled[4] * 5e-4 - gained;
        assert!((ends.dissipated.0[0] - lost).abs() < 1e-16 && lost > 0.0);
        assert!(lane(&lanes.slip, 0).iter().all(|slip| (slip - 1e-5).abs() < 1e-20));

        // The anchor tightens its end as the motor yields: it moves first.
        let reversed = |numbers: &[f64]| -> Vec<f64> { numbers.iter().rev().copied().collect() };
        let far = swept(&reversed(&old), &reversed(&COMPLIANCE), &reversed(&HALF_ANGLE), 4e-4);
        let exact = swept(&reversed(&far), &COMPLIANCE, &HALF_ANGLE, -1e-3);
        assert!(lane(&lanes.tension, 1).iter().zip(&exact).all(|(a, b)| (a - b).abs() < 4e-14), "{lanes:?}");
        assert!((ends.near.0[1] - exact[0]).abs() < 1e-14 && (ends.far.0[1] - far[0]).abs() < 1e-14);
        let gained = 0.5 * (twice_the_energy(&COMPLIANCE, &exact) - twice_the_energy(&COMPLIANCE, &old));
        let lost = exact[0] * -1e-3 - far[0] * -4e-4 - gained;
        assert!((ends.dissipated.0[1] - lost).abs() < 2e-17 && lost > 1e-4, "{lost}");
    }

    #[test]
    fn a_cable_that_was_slack_starts_as_sliding_everywhere_whether_or_not_the_step_created_energy() {
        // Tensions of no sliding cable: the first lane's were paid for by the ends, the second one's were
        // not.
        let new = [1.0, 3.0, 2.0, 2.0, 4.0];
        let (mut lanes, energy) = ending(&[0.0; 5], [new; 2]);
        let motion = Motion { motor: Row([2e-2, 1e-3]), anchor: Row([1e-3, 1e-3]) };
        let (before, stretch) = (Row([-1e-3; 2]), 2e-3);
        lanes.stretch = Row([stretch; 2]);
        let mut ends = no_ends();
        enforce_passivity(&mut lanes, &motion, before, Row([1.0; 2]), energy, &mut ends);
        for k in 0..2 {
            let tension = lane(&lanes.tension, k);
            let sum: f64 = tension.iter().zip(&COMPLIANCE).map(|(t, c)| t * c).sum();
            assert!((sum - stretch).abs() < 1e-18);
            for (pair, h) in tension.windows(2).zip(HALF_ANGLE) {
                assert!((pair[1] / pair[0] / libm::exp(-2.0 * h) - 1.0).abs() < 4e-10, "{k} {tension:?}");
            }
            let (motor, anchor) = (motion.motor.0[k], motion.anchor.0[k]);
            let energy = twice_the_energy(&COMPLIANCE, &tension);
            let lost = tension[0] * motor - tension[4] * anchor - 0.5 * energy;
            assert!((ends.dissipated.0[k] - lost).abs() < 1e-16, "{k} {lost}");
            assert!((lanes.energy.0[k] - energy).abs() < 1e-16);
        }
    }

    #[test]
    fn a_slack_cable_forgets_its_displacements_and_one_beside_it_does_not() {
        let mut lanes = LaneGroup::<2>::new(&[law(&COMPLIANCE, &HALF_ANGLE)]);
        let mut ends = no_ends();
        for k in 0..2 {
            lanes.settle(k, 1.0, Sliding::TowardMotor);
        }
        // Both slide, then the first one is let go.
        for (motor, anchor) in [([1e-3, 1e-3], 1e-3), ([-5e-3, 1e-3], 1e-3)] {
            let motion = Motion { motor: Row(motor), anchor: Row([anchor; 2]) };
            advance(&mut lanes, 1e-3, &motion, &mut ends);
        }
        assert!(lanes.stretch.0[0] < -1e-3 && lanes.stretch.0[1] > 1e-4);
        assert!(lane(&lanes.slip, 0).iter().chain(&lane(&lanes.tension, 0)).all(|number| *number == 0.0));
        assert!(lane(&lanes.slip, 1).iter().all(|slip| (5e-4..2e-3).contains(slip)), "{:?}", lanes.slip);
        // Alone, too.
        let mut alone = LaneGroup::<1>::new(&[law(&COMPLIANCE, &HALF_ANGLE)]);
        let motion = Motion { motor: Row([-1e-3]), anchor: Row::ZERO };
        advance(&mut alone, 1e-3, &motion, &mut no_ends());
        assert!(lane(&alone.slip, 0).iter().all(|slip| *slip == 0.0));
    }

    #[test]
    fn friction_follows_the_lagged_speed_of_its_own_node() {
        let mut law = law(&COMPLIANCE, &HALF_ANGLE);
        let weakening = Weakening::rational(0.5, 2e-3, 0.02);
        law.weakening = Some(weakening);
        law.nodes[0].loss = 0.01;
        let mut lanes = LaneGroup::<1>::new(&[law]);
        let (interval, speeds) = (1e-3, [1e-3, -4e-3, 0.0, 8e-3]);
        for (slip, speed) in lanes.slip[1..5].iter_mut().zip(speeds) {
            slip.0[0] = speed * interval;
        }
        for n in 0..60 {
            update_friction(&mut lanes, interval);
            for (i, speed) in speeds.iter().enumerate() {
                // Speed before and after: each step leaves tau/(tau + dt) of the distance.
                let lagged = |n: i32| speed.abs() * (1.0 - libm::pow(0.02 / 0.021, f64::from(n)));
                assert!((lanes.memory[i].speed.0[0] - lagged(n + 1)).abs() < 1e-17, "{n} {i}");
                let loss = if i == 0 { 0.01 } else { 0.0 };
                let half_angle = HALF_ANGLE[i] * weakening.factor(lagged(n)) + loss;
                assert!((lanes.nodes[i].half_angle.0[0] - half_angle).abs() < 5e-17, "{n} {i}");
                assert!((lanes.nodes[i].tanh_half.0[0] - libm::tanh(half_angle)).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn friction_weakens_while_a_cable_slides_and_only_where_it_is_said_to() {
        let plain = law(&COMPLIANCE, &HALF_ANGLE);
        let mut weak = plain.clone();
        let weakening = Weakening::rational(0.5, 2e-3, 0.01);
        weak.weakening = Some(weakening);
        let mut other = plain.clone();
        let form = WeakeningForm::Gaussian;
        other.weakening = Some(Weakening { form, ..weakening });
        let mut lanes = LaneGroup::<2>::new(&[other, plain.clone()]);
        let before = lanes.nodes[0].half_angle.0[0];
        update_friction(&mut lanes, 1e-3);
        assert!((lanes.nodes[0].half_angle.0[0] - 1.5 * before).abs() < 1e-15, "another form, at rest");
        let mut lanes = LaneGroup::<2>::new(&[weak, plain]);
        for k in 0..2 {
            lanes.settle(k, 40.0, Sliding::TowardMotor);
        }
        let motion = Motion { motor: Row([5e-5; 2]), anchor: Row([5e-5; 2]) };
        for _ in 0..100 {
            let speeds: Vec<f64> = lanes.memory.iter().map(|memory| memory.speed.0[0]).collect();
            advance(&mut lanes, 1e-3, &motion, &mut no_ends());
            for ((node, speed), h) in lanes.nodes.iter().zip(speeds).zip(HALF_ANGLE) {
                assert!((node.half_angle.0[0] - h * weakening.factor(speed)).abs() < 1e-15);
                assert!((node.half_angle.0[1] - h).abs() < 1e-15);
            }
        }
        let slid = |memory: &super::super::lane_group::Memory<2>| memory.speed.0[0] > 0.04;
        assert!(lanes.memory.iter().all(slid), "{:?}", lanes.memory);
    }
}
