//! Fit of the motion that a force makes.
//!
//! A regression of the far side's own acceleration gives the start; the search then lowers the error of the
//! simulated motion, which noise of the far side does not bias.

use super::plan::{AxisPlan, FittedAxis};
use super::sequence::Sequence;
use super::zero_phase::{Regression, rate, smooth};
use crate::fit::least_squares::{LeastSquares, Options, solve_from_many};
use sinew::predictor::{Axis, AxisMotion, Memory, MemoryLaw, Signal};

/// Filters of the regression, in sampling intervals.
const FILTERS: [f64; 2] = [2.0, 10.0];

/// Rows that are simulated in the search.
const ROWS: usize = 20_000;

/// Fraction of the rate's size below which the sign of friction is smoothed in the regression.
const REST: f64 = 0.05;

/// Time constant, in sampling intervals, from which the inertia shows.
const SHOWS: f64 = 3.0;

/// Largest fraction of the far side's variance that may be left.
const LEFT: f64 = 0.25;

/// The best axis over the forces and over velocity or position as the far side.
pub(super) fn fit(sequences: &[Sequence<'_>], plan: &AxisPlan, interval_s: f64) -> Option<FittedAxis> {
    let mut best: Option<(f64, AxisMotion)> = None;
    for &force in &plan.efforts {
        for far_is_velocity in [true, false] {
            let starts: Vec<AxisMotion> = FILTERS
                .into_iter()
                .filter_map(|filter| start(sequences, force, far_is_velocity, filter * interval_s))
                .flat_map(|law| [law.clone(), AxisMotion { friction: 0.1 * law.friction, ..law }])
                .collect();
            let Some(first) = starts.first() else { continue };
            let problem = Simulated::new(sequences, first);
            let starts: Vec<Vec<f64>> = starts.iter().map(|law| problem.searched(law)).collect();
            let Some(found) = solve_from_many(&problem, &starts, Options { steps: 30, tolerance: 1e-5 })
            else {
                continue;
            };
            if best.as_ref().is_none_or(|(least, _)| found.squares < *least) {
                best = Some((found.squares, problem.law(&found.theta)));
            }
        }
    }
    let (squares, law) = best?;
    let slow = if law.stiffness > 0.0 { law.stiffness.sqrt().max(law.damping) } else { law.damping };
    let inertia_shows = slow * SHOWS * interval_s < 1.0 && squares < LEFT * variance(sequences);
    Some(FittedAxis { axis: Axis::Motion(law), inertia_shows })
}

/// Sum of the squared deviations of the far side from its mean, over the simulated rows.
fn variance(sequences: &[Sequence<'_>]) -> f64 {
    let far = || kept(sequences).into_iter().flat_map(|(s, n)| s.far[..n].iter().zip(&s.weight[..n]));
    let (sum, count) = far().fold((0.0, 0.0), |(s, n), (y, w)| (s + w * y, n + w));
    let mean = sum / f64::max(count, 1.0);
    far().map(|(y, w)| w * (y - mean) * (y - mean)).sum()
}

/// Sequences with the number of their rows that are simulated.
fn kept<'a, 'b>(sequences: &'a [Sequence<'b>]) -> Vec<(&'a Sequence<'b>, usize)> {
    let mut left = ROWS;
    let mut take = |sequence: &'a Sequence<'b>| {
        let rows = sequence.far.len().min(left);
        left -= rows;
        (sequence, rows)
    };
    sequences.iter().map(&mut take).filter(|(_, rows)| *rows > 0).collect()
}

/// An axis by linear regression of the acceleration of the far side.
fn start(sequences: &[Sequence<'_>], force: usize, far_is_velocity: bool, tau_s: f64) -> Option<AxisMotion> {
    let size = |sequence: &Sequence<'_>| {
        let velocity = velocity(sequence, far_is_velocity, tau_s);
        velocity.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
    };
    let rest = REST * sequences.iter().map(size).fold(0.0, f64::max);
    if rest <= 0.0 {
        return None;
    }
    // Columns: force, velocity, direction, one, position.
    let of = |sequence: &Sequence<'_>| {
        let smoothed = velocity(sequence, far_is_velocity, tau_s);
        let raw = if far_is_velocity { sequence.far.to_vec() } else { rate(sequence.far, sequence.dt_s) };
        let direction = smoothed.iter().map(|v| (v / rest).tanh()).collect();
        let target = rate(&raw, sequence.dt_s);
        let n = target.len();
        let position = if far_is_velocity { vec![0.0; n] } else { sequence.far.to_vec() };
        (vec![sequence.signals[force].clone(), raw, direction, vec![1.0; n], position], target)
    };
    let used: &[usize] = if far_is_velocity { &[0, 1, 2, 3] } else { &[0, 1, 2, 3, 4] };
    let (found, _) = Regression::new(sequences, tau_s, of).solve(used)?;
    let scale = found[0].abs() * largest(sequences, force);
    Some(AxisMotion {
        force,
        gain: found[0],
        damping: (-found[1]).max(1e-2),
        stiffness: if far_is_velocity { 0.0 } else { (-found[4]).max(1e-2) },
        friction: (-found[2]).max(1e-3 * scale).max(1e-12),
        bias: -found[3],
        offset: 0.0,
        far_is_velocity,
    })
}

/// Largest magnitude of a signal.
fn largest(sequences: &[Sequence<'_>], signal: usize) -> f64 {
    sequences.iter().flat_map(|sequence| &sequence.signals[signal]).fold(0.0, |m: f64, f| m.max(f.abs()))
}

/// Velocity of the far side, smoothed without lag.
fn velocity(sequence: &Sequence<'_>, far_is_velocity: bool, tau_s: f64) -> Vec<f64> {
    let mut velocity =
        if far_is_velocity { sequence.far.to_vec() } else { rate(sequence.far, sequence.dt_s) };
    smooth(&mut velocity, sequence.dt_s, tau_s);
    velocity
}

/// The error of the simulated motion.
struct Simulated<'a, 'b> {
    kept: Vec<(&'a Sequence<'b>, usize)>,
    force: usize,
    far_is_velocity: bool,
    rows: usize,
    /// Units of gain and bias, so that the search sees numbers near one.
    units: [f64; 2],
}

impl<'a, 'b> Simulated<'a, 'b> {
    fn new(sequences: &'a [Sequence<'b>], near: &AxisMotion) -> Self {
        let kept = kept(sequences);
        let rows = kept.iter().map(|(_, rows)| rows).sum();
        let gain = near.gain.abs().max(1e-30);
        let units = [gain, gain * largest(sequences, near.force).max(1e-30)];
        Self { kept, force: near.force, far_is_velocity: near.far_is_velocity, rows, units }
    }

    /// Parameters of the search: gain, bias, logarithms of damping and friction, and of the stiffness.
    fn searched(&self, law: &AxisMotion) -> Vec<f64> {
        let [gain, bias] = [law.gain / self.units[0], law.bias / self.units[1]];
        let mut theta = vec![gain, bias, law.damping.ln(), law.friction.ln()];
        theta.extend((!self.far_is_velocity).then(|| law.stiffness.ln()));
        theta
    }

    fn law(&self, theta: &[f64]) -> AxisMotion {
        let positive = |k: usize| theta.get(k).map_or(0.0, |t| t.clamp(-60.0, 60.0).exp());
        AxisMotion {
            force: self.force,
            gain: theta[0] * self.units[0],
            bias: theta[1] * self.units[1],
            damping: positive(2),
            friction: positive(3),
            stiffness: if self.far_is_velocity { 0.0 } else { positive(4) },
            offset: 0.0,
            far_is_velocity: self.far_is_velocity,
        }
    }
}

impl LeastSquares for Simulated<'_, '_> {
    fn parameters(&self) -> usize {
        if self.far_is_velocity { 4 } else { 5 }
    }

    fn residuals(&self) -> usize {
        self.rows
    }

    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool {
        if !theta.iter().all(|t| t.is_finite()) {
            return false;
        }
        let axis = Axis::Motion(AxisMotion { force: 0, ..self.law(theta) });
        let law = MemoryLaw {
            signals: vec![Signal::Input(0)],
            cell: None,
            cable: None,
            axis: Some(axis),
            features: Vec::new(),
        };
        let mut memory = Memory::new(&law);
        let mut place = residuals.iter_mut();
        for (sequence, rows) in &self.kept {
            memory.reset();
            for i in 0..*rows {
                let far = (i == 0 && sequence.weight[0] > 0.0).then_some(sequence.far[0]);
                memory.step_from(&law, sequence.dt_s[i], &[sequence.signals[self.force][i]], far);
                if let Some(residual) = place.next() {
                    *residual = sequence.weight[i] * (memory.cell().state - sequence.far[i]);
                    if !residual.is_finite() {
                        return false;
                    }
                }
            }
        }
        true
    }
}
