//! What a step does in the rare lane that it cannot solve: taking tension up again, and the exact play sweeps.

use super::lane_group::LaneGroup;
use super::travel::{Seen, move_end};

/// A cable that was slack and is not any more slides everywhere: the profile of sliding, with the stretch it has.
///
/// Friction without speed; whichever end moves more decides the direction. Returns both ends' tensions.
#[cold]
#[inline(never)]
pub(super) fn re_tension<const N: usize>(
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
            ratio *= across(s * lanes.nodes[j - 1].grip.0[k]);
            let x = j as f64 / m as f64;
            lanes.slip[j].0[k] = motor + (anchor - motor) * x;
        }
        lanes.next[j].0[k] = ratio;
        sum += lanes.compliance[j].0[k] * ratio;
    }
    let unit = lanes.stretch.0[k] / sum;
    let mut energy = 0.0;
    for (next, compliance) in lanes.next.iter_mut().zip(&lanes.compliance) {
        next.0[k] *= unit;
        energy += compliance.0[k] * next.0[k] * next.0[k];
    }
    lanes.energy.0[k] = energy;
    (lanes.next[0].0[k], lanes.next[m - 1].0[k])
}

/// Both ends moved one after the other from the tensions before the step, what tightens first.
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
    for (next, tension) in lanes.next.iter_mut().zip(&lanes.tension) {
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
    for (next, compliance) in lanes.next.iter().zip(&lanes.compliance) {
        energy += compliance.0[k] * next.0[k] * next.0[k];
    }
    lanes.energy.0[k] = energy;
    for slip in &mut lanes.slip {
        slip.0[k] = 0.0;
    }
    (near.unwrap_or(lanes.next[0].0[k]), far.unwrap_or(lanes.next[m - 1].0[k]))
}

/// Moves the drive's end; its tension, or none where it stands still.
fn sweep_near<const N: usize>(lanes: &mut LaneGroup<N>, k: usize, distance: f64) -> Option<f64> {
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut ratio = 1.0;
    for j in 0..lanes.next.len() {
        if j > 0 {
            ratio *= across(s * lanes.nodes[j - 1].grip.0[k]);
        }
        let (tension, compliance) = (lanes.next[j].0[k], lanes.compliance[j].0[k]);
        lanes.column[j] = Seen { tension, compliance, ratio };
    }
    let moved = move_end(&mut lanes.column, distance);
    for (next, cell) in lanes.next.iter_mut().zip(&lanes.column) {
        next.0[k] = cell.tension;
    }
    (distance != 0.0).then_some(moved)
}

/// Moves the anchor's end away from the motor by `distance`; its tension, or none where it stands still.
fn sweep_far<const N: usize>(lanes: &mut LaneGroup<N>, k: usize, distance: f64) -> Option<f64> {
    let m = lanes.next.len();
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut ratio = 1.0;
    for j in (0..m).rev() {
        if j + 1 < m {
            ratio *= across(s * lanes.nodes[j].grip.0[k]);
        }
        let (tension, compliance) = (lanes.next[j].0[k], lanes.compliance[j].0[k]);
        lanes.column[m - 1 - j] = Seen { tension, compliance, ratio };
    }
    let moved = move_end(&mut lanes.column, distance);
    for (next, cell) in lanes.next.iter_mut().zip(lanes.column.iter().rev()) {
        next.0[k] = cell.tension;
    }
    (distance != 0.0).then_some(moved)
}

/// `e^(-2 h)` from `tanh h`: tension behind a sliding node over that in front of it, as the step has it.
pub(super) fn across(grip: f64) -> f64 {
    (1.0 - grip) / (1.0 + grip)
}
