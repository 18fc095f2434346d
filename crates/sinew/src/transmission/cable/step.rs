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
        for k in 0..N {
            // As `Weakening::factor`, with the speed scaled before it is squared.
            let ratio = z.0[k] * law.inverse_speed.0[k];
            let factor = 1.0 + law.rise.0[k] / (1.0 + ratio * ratio);
            z.0[k] += interval / (law.lag.0[k] + interval) * (w.0[k].abs() / interval - z.0[k]);
            half_angle.0[k] = friction.0[k] * factor + loss.0[k];
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
