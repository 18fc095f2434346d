//! One step of the law: balance at every node, linearised where the last step left it, solved in one pass.

use super::lane_group::{Ends, LaneGroup, Motion, Row};
use super::repair::{re_tension, sweep_both_ends};

/// Friction bound, N, below which a node is free: no wrap, or no tension.
const FREE: f64 = 1e-12;
/// Work, J, by which friction may seem to push along before a node is held.
const PUSH: f64 = 1e-10;
/// Energy, J, that a step may seem to create by rounding.
const ROUNDING: f64 = 1e-12;
/// Largest argument of [`tanh_series`]; drag beyond it stays what it is there.
const SERIES_END: f64 = 0.5;

/// `tanh x` as an odd polynomial, `x` held within +-0.5: relative error 2e-9 up to 0.15, 2e-5 at 0.4.
#[inline(always)]
pub(super) fn tanh_series(x: f64) -> f64 {
    let x = at_most(at_least(x, -SERIES_END), SERIES_END);
    let z = x * x;
    x * (1.0 + z * (-1.0 / 3.0 + z * (2.0 / 15.0 + z * (-17.0 / 315.0))))
}

/// The larger one, as one machine instruction: `f64::max` has to think of NaN.
#[inline(always)]
fn at_least(x: f64, least: f64) -> f64 {
    if x > least { x } else { least }
}

#[inline(always)]
fn at_most(x: f64, most: f64) -> f64 {
    if x < most { x } else { most }
}

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
        weaken(lanes, interval);
    }
    let rate = 1.0 / interval;
    for _ in 1..lanes.iterations {
        eliminate(lanes, rate, motion);
        correct(lanes);
    }
    eliminate(lanes, rate, motion);
    let (scale, energy) = substitute(lanes);
    certify(lanes, motion, before, scale, energy, ends);
}

/// Friction coefficients from the lagged speed of every node.
#[inline(always)]
fn weaken<const N: usize>(lanes: &mut LaneGroup<N>, interval: f64) {
    let Some(law) = lanes.weakening else { return };
    for (i, (memory, node)) in lanes.memory.iter_mut().zip(&mut lanes.nodes).enumerate() {
        let (friction, loss, mut z, w) = (memory.friction, memory.loss, memory.speed, lanes.slip[i + 1]);
        let (mut half, mut grip) = (Row::<N>::ZERO, Row::<N>::ZERO);
        for k in 0..N {
            // As `Weakening::factor`, with the speed scaled before it is squared.
            let ratio = z.0[k] * law.inverse_speed.0[k];
            let factor = 1.0 + law.rise.0[k] / (1.0 + ratio * ratio);
            z.0[k] += interval / (law.lag.0[k] + interval) * (w.0[k].abs() / interval - z.0[k]);
            half.0[k] = friction.0[k] * factor + loss.0[k];
            grip.0[k] = tanh_series(half.0[k]);
        }
        (memory.speed, node.half, node.grip) = (z, half, grip);
    }
}

/// Forward: the balance of every node around the last displacements, eliminated at once.
#[inline(always)]
fn eliminate<const N: usize>(lanes: &mut LaneGroup<N>, rate: f64, motion: &Motion<N>) {
    let m = lanes.tension.len();
    let (tension, stiffness) = (&lanes.tension[..m], &lanes.stiffness[..m]);
    let (nodes, slip) = (&lanes.nodes[..m - 1], &lanes.slip[..=m]);
    let (up, known) = (&mut lanes.up[..m], &mut lanes.known[..m]);
    let fade = lanes.fade;
    let (mut a, mut b) = (Row::<N>::ZERO, Row::<N>::ZERO);
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
            // Which way does it slide, or does it stick?
            let bound = sum * node.grip.0[k];
            let trial = difference + (kl + kr) * w;
            let lead = if motion.motor.0[k] + motion.anchor.0[k] >= 0.0 { 1.0 } else { -1.0 };
            let sliding = if trial > bound {
                1.0
            } else if trial < -bound {
                -1.0
            } else {
                0.0
            };
            let sign = if bound <= FREE { lead } else { sliding };
            // Friction of a sliding node, and its slope in the displacement.
            let resistance = (node.viscous.0[k] + node.drag.0[k] / (sum + fade.0[k])) * rate;
            let tau = tanh_series(sign * node.half.0[k] + resistance * w);
            let (down, ahead) = ((1.0 - tau) * kl, (1.0 + tau) * kr);
            let own = down + ahead + sum * (1.0 - tau * tau) * resistance;
            let rest = difference - tau * both;
            let sticks = sign == 0.0;
            let down = if sticks { 0.0 } else { down };
            let ahead = if sticks { 0.0 } else { ahead };
            let own = if sticks { 1.0 } else { own };
            let rest = if sticks { -w } else { rest };
            let inverse = 1.0 / (own - down * a.0[k]);
            b.0[k] = (rest + down * b.0[k]) * inverse;
            a.0[k] = ahead * inverse;
        }
        up[i + 1] = a;
        known[i + 1] = b;
    }
}

/// Backward without tensions: a Newton step that is not the last one.
#[inline(always)]
fn correct<const N: usize>(lanes: &mut LaneGroup<N>) {
    let m = lanes.tension.len();
    let (up, known, slip) = (&lanes.up[..m], &lanes.known[..m], &mut lanes.slip[..m]);
    let mut x = Row::<N>::ZERO;
    for i in (1..m).rev() {
        let (up, known, mut w) = (up[i], known[i], slip[i]);
        for k in 0..N {
            x.0[k] = known.0[k] + up.0[k] * x.0[k];
            w.0[k] += x.0[k];
        }
        slip[i] = w;
    }
}

/// Backward: displacements, the guard, tensions before scaling. Returns the scale that makes the total
/// stretch exact, and twice the elastic energy after it.
#[inline(always)]
fn substitute<const N: usize>(lanes: &mut LaneGroup<N>) -> (Row<N>, Row<N>) {
    let m = lanes.tension.len();
    let (tension, stiffness) = (&lanes.tension[..m], &lanes.stiffness[..m]);
    let (compliance, next) = (&lanes.compliance[..m], &mut lanes.next[..m]);
    let (up, known, slip) = (&lanes.up[..m], &lanes.known[..m], &mut lanes.slip[..=m]);
    let (mut sum, mut energy) = (Row::<N>::ZERO, Row::<N>::ZERO);
    // Node `j` lies left of cell `j`; node 0 is the winch, which `up` and `known` leave where it is. Of the node
    // in hand: correction, displacement as solved; the displacement beyond it as guarded; tension of the cell beyond as solved.
    let mut x = known[m - 1];
    let (mut solved, mut beyond, mut right) = (slip[m - 1], slip[m], Row::<N>::ZERO);
    for k in 0..N {
        solved.0[k] += x.0[k];
        right.0[k] = tension[m - 1].0[k] + (solved.0[k] - beyond.0[k]) * stiffness[m - 1].0[k];
    }
    for j in (0..m - 1).rev() {
        let (up, known, w, t, stiff) = (up[j], known[j], slip[j], tension[j], stiffness[j]);
        let (t_beyond, stiff_beyond, c_beyond) = (tension[j + 1], stiffness[j + 1], compliance[j + 1]);
        let (mut t_next, mut kept) = (Row::<N>::ZERO, Row::<N>::ZERO);
        for k in 0..N {
            x.0[k] = known.0[k] + up.0[k] * x.0[k];
            let w = w.0[k] + x.0[k];
            let left = t.0[k] + (w - solved.0[k]) * stiff.0[k];
            // Both tensions of the node are there now: friction never pushes along.
            let pushes = (left - right.0[k]) * solved.0[k] < -PUSH;
            kept.0[k] = if pushes { 0.0 } else { solved.0[k] };
            let t = at_least(t_beyond.0[k] + (kept.0[k] - beyond.0[k]) * stiff_beyond.0[k], 0.0);
            t_next.0[k] = t;
            sum.0[k] += c_beyond.0[k] * t;
            energy.0[k] += c_beyond.0[k] * t * t;
            beyond.0[k] = kept.0[k];
            solved.0[k] = w;
            right.0[k] = left;
        }
        next[j + 1] = t_next;
        slip[j + 1] = kept;
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

/// Accepts what created no energy, repairs what did, and re-tensions what was slack.
#[inline(always)]
fn certify<const N: usize>(
    lanes: &mut LaneGroup<N>,
    motion: &Motion<N>,
    before: Row<N>,
    mut scale: Row<N>,
    energy: Row<N>,
    ends: &mut Ends<N>,
) {
    let m = lanes.tension.len();
    let (old, first, last, after) = (lanes.energy, lanes.next[0], lanes.next[m - 1], lanes.stretch);
    let (mut near, mut far, mut dissipated) = (Row::<N>::ZERO, Row::<N>::ZERO, Row::<N>::ZERO);
    // Not zero where a lane was slack and is not, or seems to have created energy.
    let mut repair = Row::<N>::ZERO;
    for k in 0..N {
        near.0[k] = first.0[k] * scale.0[k];
        far.0[k] = last.0[k] * scale.0[k];
        let work = near.0[k] * motion.motor.0[k] - far.0[k] * motion.anchor.0[k];
        dissipated.0[k] = work - 0.5 * (energy.0[k] - old.0[k]);
        let cold = (before.0[k] <= 0.0) & (after.0[k] > 0.0);
        repair.0[k] = if cold | (dissipated.0[k] < -ROUNDING) { 1.0 } else { 0.0 };
    }
    *ends = Ends { near, far, dissipated };
    lanes.energy = energy;
    if repair.0.iter().sum::<f64>() > 0.0 {
        for k in (0..N).filter(|k| repair.0[*k] > 0.0) {
            let (motor, anchor) = (motion.motor.0[k], motion.anchor.0[k]);
            let (near, far) = if before.0[k] <= 0.0 {
                re_tension(lanes, k, motor, anchor)
            } else {
                sweep_both_ends(lanes, k, motor, anchor)
            };
            scale.0[k] = 1.0;
            ends.near.0[k] = near;
            ends.far.0[k] = far;
            ends.dissipated.0[k] = near * motor - far * anchor - 0.5 * (lanes.energy.0[k] - old.0[k]);
        }
    }
    for (tension, next) in lanes.tension.iter_mut().zip(&lanes.next) {
        let mut scaled = Row::<N>::ZERO;
        for k in 0..N {
            scaled.0[k] = next.0[k] * scale.0[k];
        }
        *tension = scaled;
    }
    rest_where_slack(lanes);
}

/// A slack cable has no displacements to start the next step from.
#[inline(always)]
fn rest_where_slack<const N: usize>(lanes: &mut LaneGroup<N>) {
    if lanes.stretch.0.iter().any(|stretch| *stretch <= 0.0) {
        for slip in &mut lanes.slip {
            for k in 0..N {
                slip.0[k] = if lanes.stretch.0[k] <= 0.0 { 0.0 } else { slip.0[k] };
            }
        }
    }
}
