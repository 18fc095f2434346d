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
