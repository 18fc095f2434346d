//! Fit of the force that moves an axis.

use super::plan::{AxisPlan, FittedAxis};
use super::sequence::{Sequence, causal_squares};
use super::zero_phase::{Regression, rate, smooth};
use crate::fit::run::Run;
use sinew::predictor::{Axis, AxisForce, AxisSlip, MemoryLaw};
use sinew::transmission::Play;

/// Distances of presliding as fractions of the range of the position.
const DISTANCES: [f64; 3] = [0.0005, 0.005, 0.05];

/// Filters of the regression, and memories of the differentiator at run time, in sampling intervals.
const FILTERS: [f64; 2] = [8.0, 24.0];
const MEMORIES: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Correlation from which one motion is the rate of another.
const IS_RATE: f64 = 0.9;

/// Residual without over residual with inertia, squares, from which the inertia shows.
const SHOWS: f64 = 1.3;

/// What is read as position and what as velocity.
#[derive(Debug, Clone, Copy)]
struct Kinematics {
    position: Option<usize>,
    velocity: Option<usize>,
    gain: f64,
}

impl Kinematics {
    /// Every motion as a position and as a velocity, and every pair of which one is the rate of the other.
    fn all(sequences: &[Sequence<'_>], motions: &[usize], tau_s: f64) -> Vec<Self> {
        let mut all = Vec::new();
        for &motion in motions {
            all.push(Self { position: Some(motion), velocity: None, gain: 1.0 });
            all.push(Self { position: None, velocity: Some(motion), gain: 1.0 });
            for &velocity in motions.iter().filter(|&&other| other != motion) {
                if let Some(gain) = rate_per(sequences, motion, velocity, tau_s) {
                    all.push(Self { position: Some(motion), velocity: Some(velocity), gain });
                }
            }
        }
        all
    }

    /// Position, velocity and acceleration of a sequence, before any smoothing; without a position its
    /// integral.
    fn motion(&self, sequence: &Sequence<'_>) -> [Vec<f64>; 3] {
        let velocity = match (self.velocity, self.position) {
            (Some(signal), _) => sequence.signals[signal].iter().map(|v| self.gain * v).collect(),
            (None, Some(signal)) => rate(&sequence.signals[signal], sequence.dt_s),
            (None, None) => vec![0.0; sequence.far.len()],
        };
        let position = self.position.map_or_else(
            || {
                let mut travel = 0.0;
                let steps = velocity.iter().zip(sequence.dt_s);
                steps
                    .map(|(v, dt)| {
                        travel += v * dt;
                        travel
                    })
                    .collect()
            },
            |signal| sequence.signals[signal].clone(),
        );
        let acceleration = rate(&velocity, sequence.dt_s);
        [position, velocity, acceleration]
    }
}

/// Factor of a velocity to be the rate of a position, where it is one.
fn rate_per(sequences: &[Sequence<'_>], position: usize, velocity: usize, tau_s: f64) -> Option<f64> {
    let (mut rr, mut rv, mut vv) = (0.0, 0.0, 0.0);
    for sequence in sequences {
        let mut rates = rate(&sequence.signals[position], sequence.dt_s);
        let mut measured = sequence.signals[velocity].clone();
        [&mut rates, &mut measured].into_iter().for_each(|column| smooth(column, sequence.dt_s, tau_s));
        for (r, v) in rates.iter().zip(&measured) {
            (rr, rv, vv) = (rr + r * r, rv + r * v, vv + v * v);
        }
    }
    (rv.abs() > IS_RATE * (rr * vv).sqrt() && vv > 0.0).then(|| rv / vv)
}

/// Largest range of the position within a sequence.
fn travel(sequences: &[Sequence<'_>], kinematics: Kinematics) -> f64 {
    let range = |sequence: &Sequence<'_>| {
        let [position, _, _] = kinematics.motion(sequence);
        let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        high - low
    };
    sequences.iter().map(range).fold(0.0, f64::max)
}

/// Stops of a position, as fractions of their radius.
fn stops(play: Play, position: &[f64]) -> Vec<f64> {
    let mut at = position.first().copied().unwrap_or(0.0);
    let step = |&x: &f64| {
        at = play.step(at, x);
        play.stop(at, x) / play.radius()
    };
    position.iter().map(step).collect()
}

/// The best axis over all readings of the columns, filters and memories; by the error of the causal
/// prediction.
pub(super) fn fit(
    signals: &MemoryLaw,
    runs: &[&Run],
    sequences: &[Sequence<'_>],
    plan: &AxisPlan,
    interval_s: f64,
) -> Option<FittedAxis> {
    let mut best: Option<(f64, FittedAxis)> = None;
    for kinematics in Kinematics::all(sequences, &plan.motions, FILTERS[0] * interval_s) {
        for filter in FILTERS {
            let Some((law, inertia_shows)) = regress(sequences, plan, kinematics, filter * interval_s) else {
                continue;
            };
            for memory in MEMORIES {
                let axis = Axis::Force(AxisForce { tau_s: (memory * interval_s).max(1e-6), ..law.clone() });
                let squares = causal_squares(signals, runs, &axis);
                if best.as_ref().is_none_or(|(least, _)| squares < *least) {
                    best = Some((squares, FittedAxis { axis, inertia_shows }));
                }
            }
        }
    }
    best.map(|(_, fitted)| fitted)
}

/// The axis by linear least squares, and whether its inertia shows.
fn regress(
    sequences: &[Sequence<'_>],
    plan: &AxisPlan,
    kinematics: Kinematics,
    tau_s: f64,
) -> Option<(AxisForce, bool)> {
    let range = travel(sequences, kinematics);
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    let distances = DISTANCES.map(|fraction| fraction * range);
    let plays: Vec<Play> =
        distances.iter().map(|distance| Play::new(*distance).ok()).collect::<Option<_>>()?;
    // Columns: acceleration, velocity, position, one, stops, near forces.
    let of = |sequence: &Sequence<'_>| {
        let [position, velocity, acceleration] = kinematics.motion(sequence);
        let spring = if kinematics.position.is_some() { position.clone() } else { vec![0.0; position.len()] };
        let mut columns = vec![acceleration, velocity, spring, vec![1.0; position.len()]];
        columns.extend(plays.iter().map(|play| stops(*play, &position)));
        columns.extend(plan.efforts.iter().map(|&effort| sequence.signals[effort].clone()));
        (columns, sequence.far.to_vec())
    };
    let regression = Regression::new(sequences, tau_s, of);
    let first_effort = 4 + distances.len();
    let slips: Vec<usize> = (4..first_effort).collect();
    let (found, squares) = regression.solve_one_sided(&slips)?;
    let used: Vec<usize> = (1..first_effort + plan.efforts.len()).filter(|&i| found[i].abs() > 0.0).collect();
    let (_, without) = regression.solve(&used)?;
    let slip = |(distance, force): (&f64, &f64)| AxisSlip { distance: *distance, force: *force };
    let law = AxisForce {
        position: kinematics.position,
        velocity: kinematics.velocity,
        velocity_gain: kinematics.gain,
        tau_s,
        mass: found[0],
        damping: found[1],
        stiffness: found[2],
        slips: distances.iter().zip(&found[4..]).map(slip).filter(|slip| slip.force.abs() > 0.0).collect(),
        gains: plan.efforts.iter().copied().zip(found[first_effort..].iter().copied()).collect(),
        offset: found[3],
    };
    Some((law, without > SHOWS * squares))
}
