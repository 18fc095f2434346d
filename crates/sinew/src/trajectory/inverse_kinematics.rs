use super::nearest::Nearest;
use super::ranges::independent_ranges;
use super::redundancy::Redundancy;
use crate::body::vector::{dot, norm, product};
use crate::body::{IndependentKinematics, JointKind, Robot};
use crate::error::{Error, within};
use alloc::vec;
use alloc::vec::Vec;

/// Inverse kinematics of the independent joints within their ranges, with preallocated matrices.
///
/// ```text
/// settle   y = argmin 1/2 |y - r|_W^2 + s/2 |y - x|_W^2   so that   J (y - x) = p - p(x),  low <= y <= high
/// reach    y = argmin 1/2 |p - p(x) - J (y - x)|^2 + m/2 |y - x|_W^2   so that   low <= y <= high
/// both     x <- x + min(1, min_i stride_i/|y_i - x_i|) (y - x)
/// ```
///
/// | symbol    | meaning                                                                     | unit     |
/// |-----------|-----------------------------------------------------------------------------|----------|
/// | x, y      | independent joints before and after a step: `[n]`                            | rad or m |
/// | r, W      | preferred pose and weights of [`Redundancy`]                                 | rad or m, 1 |
/// | p, p(x), J | target; end point and its Jacobian at `x`, in the axes of the task           | m        |
/// | s         | weight of the proximal term                                                  | 1        |
/// | m         | damping: `max(d tr(J W^-1 J^T), 0.3 abs(p - p(x)) sqrt(tr(J W^-1 J^T)))`, `d` adapted | m^2 |
///
/// `settle` finds the pose of the redundancy resolution: sequential linearisation, for `s > 0` with a
/// proximal term where the curvature of the constraint is large; it converges linearly. `reach` is the method
/// of Levenberg and Marquardt with bounds: it finds some pose from any start, or the closest one nearby.
///
/// # Source
/// `whitney1969` for the weighted pseudo-inverse; `marquardt1963`; solving for a pose instead of integrating
/// velocities is ours.
#[derive(Debug, Clone)]
pub(super) struct Solver<'a> {
    pub(super) robot: &'a Robot,
    rule: &'a Redundancy,
    site: usize,
    axes: [bool; 3],
    pub(super) ranges: Vec<[f64; 2]>,
    /// Largest change of a joint per iteration, rad or m: `[n]`.
    strides: Vec<f64>,
    /// With the Jacobian of the task; its rows of axes outside the task are zero.
    pub(super) kinematics: IndependentKinematics,
    preferred: Vec<f64>,
    next: Vec<f64>,
}

/// Largest position error of a reached point, m.
pub(super) const POSITION_TOLERANCE: f64 = 1e-9;
/// Largest joint step at convergence, rad or m.
const STEP_TOLERANCE: f64 = 1e-12;
/// Most iterations of `settle` without a proximal term.
const SETTLE_ITERATIONS: usize = 300;
/// Iterations of `settle` without a proximal term within which the largest step must fall to 0.9 of its
/// value; else it gives up.
const SETTLE_WINDOW: usize = 40;
/// Weights `s` of the proximal term, tried in order.
const PROXIMITIES: [f64; 4] = [0.0, 3.0, 15.0, 75.0];
/// Regularisation of the equations, relative to the trace of `J W^-1 J^T`.
const REGULARIZATION: f64 = 1e-11;
/// Most iterations of `reach`.
const REACH_ITERATIONS: usize = 200;
/// Least damping of `reach`, as a fraction of `|p - p(x)|` times the root of the trace of `J W^-1 J^T`.
const CURVATURE: f64 = 0.3;
/// Squared cosine between the position error and the closest direction of motion at convergence of `reach`.
const STATIONARY: f64 = 1e-11;

impl<'a> Solver<'a> {
    /// For the end point at a site, by its index, in those of the world's axes that are true.
    ///
    /// # Errors
    /// As [`Redundancy::validate`]; [`Error::OutOfDomain`] for an index out of range and for no axis.
    pub(super) fn new(
        robot: &'a Robot,
        rule: &'a Redundancy,
        site: usize,
        axes: [bool; 3],
    ) -> Result<Self, Error> {
        rule.validate(robot)?;
        within("site", "an index of a site", site as f64, site < robot.parts().sites.len())?;
        within("axes", "at least one", 0.0, axes.contains(&true))?;
        let n = rule.rest.len();
        let ranges = independent_ranges(robot)?;
        let stride = |(&joint, range): (&usize, &[f64; 2])| match robot.parts().joints[joint].kind {
            JointKind::Slide => (0.2 * (range[1] - range[0])).min(0.3),
            _ => 0.3,
        };
        let strides = robot.independent_joints().iter().zip(&ranges).map(stride).collect();
        Ok(Self {
            rule,
            site,
            axes,
            strides,
            ranges,
            kinematics: IndependentKinematics::new(robot),
            preferred: vec![0.0; n],
            next: vec![0.0; n],
            robot,
        })
    }

    /// The same solver without the joints' ranges.
    pub(super) fn without_ranges(&self) -> Self {
        let ranges = vec![[f64::NEG_INFINITY, f64::INFINITY]; self.ranges.len()];
        Self { ranges, ..self.clone() }
    }

    /// The rest pose, within the ranges.
    pub(super) fn rest(&self) -> Vec<f64> {
        self.rule.rest.iter().zip(&self.ranges).map(|(rest, [low, high])| rest.max(*low).min(*high)).collect()
    }

    /// Moves `x`, from a pose nearby, to the pose for `target`, m, at a phase, rad; `false` where that fails.
    pub(super) fn solve(&mut self, phase: f64, target: [f64; 3], x: &mut [f64]) -> Result<bool, Error> {
        let start = x.to_vec();
        for proximity in PROXIMITIES {
            if proximity > 0.0 {
                // A pose on the task, close to the start, from which the proximal term moves in small steps.
                x.copy_from_slice(&start);
                if self.reach(target, x)? > POSITION_TOLERANCE {
                    return Ok(false);
                }
            }
            if self.settle(phase, target, x, proximity)? <= POSITION_TOLERANCE {
                return Ok(true);
            }
        }
        // No pose is locally the closest to the preferred one: any that is reached from the start.
        x.copy_from_slice(&start);
        Ok(self.reach(target, x)? <= POSITION_TOLERANCE)
    }

    /// Iterates to the pose on the target that is closest to the preferred one; returns the position error,
    /// m, or infinity without convergence.
    fn settle(&mut self, phase: f64, target: [f64; 3], x: &mut [f64], proximity: f64) -> Result<f64, Error> {
        let sine = libm::sin(phase);
        let mut multipliers = [0.0; 3];
        let window = SETTLE_WINDOW + proximity as usize;
        let mut earlier = f64::INFINITY;
        for iteration in 1..=SETTLE_ITERATIONS * (1 + proximity as usize) {
            let error = self.error(target, x)?;
            for (i, preferred) in self.preferred.iter_mut().enumerate() {
                *preferred = (self.rule.preferred(i, sine) + proximity * x[i]) / (1.0 + proximity);
            }
            let regularization = REGULARIZATION * self.trace();
            self.nearest(error, regularization, x, &mut multipliers);
            let largest = self.advance(x);
            if largest < STEP_TOLERANCE {
                return Ok(norm(self.error(target, x)?));
            }
            if iteration % window == 0 {
                if largest > 0.9 * earlier {
                    break;
                }
                earlier = largest;
            }
        }
        Ok(f64::INFINITY)
    }

    /// Moves `x` to a pose for `target`, or to one nearby whose end point is closest to it; returns the
    /// remaining position error, m.
    pub(super) fn reach(&mut self, target: [f64; 3], x: &mut [f64]) -> Result<f64, Error> {
        let mut damping = 1e-3;
        let mut error = self.error(target, x)?;
        let mut before = x.to_vec();
        for _ in 0..REACH_ITERATIONS {
            before.copy_from_slice(x);
            self.preferred.copy_from_slice(x);
            // The curvature of the end point's motion counts as well: of the order of error times length.
            let trace = self.trace();
            let regularization = (damping * trace).max(CURVATURE * norm(error) * libm::sqrt(trace));
            self.nearest(error, regularization, x, &mut [0.0; 3]);
            let (rows, n) = (&self.kinematics.rows, x.len());
            let remaining: [f64; 3] = core::array::from_fn(|k| {
                let row = &rows[k * n..(k + 1) * n];
                error[k] - product(row, &self.next) + product(row, x)
            });
            let [now, predicted] = [error, remaining].map(|e| dot(e, e));
            if predicted >= now || now < 1e-28 || damping > 1e12 || self.stationary(error, &before) {
                break;
            }
            self.advance(x);
            let trial = self.error(target, x)?;
            if dot(trial, trial) < now {
                error = trial;
                damping = (0.1 * damping).max(1e-14);
            } else {
                x.copy_from_slice(&before);
                self.error(target, x)?;
                damping *= 8.0;
            }
        }
        Ok(norm(error))
    }

    /// Whether the position error is perpendicular to what the joints can do within their ranges.
    fn stationary(&self, error: [f64; 3], x: &[f64]) -> bool {
        let n = x.len();
        let mut squares = 0.0;
        for (i, [low, high]) in self.ranges.iter().enumerate() {
            let pull: f64 = (0..3).map(|k| self.kinematics.rows[k * n + i] * error[k]).sum();
            if (x[i] > *low || pull > 0.0) && (x[i] < *high || pull < 0.0) {
                squares += pull * pull / self.rule.weight[i];
            }
        }
        squares <= STATIONARY * self.trace() * dot(error, error)
    }

    /// Position error of the end point in the task's axes, m; updates the Jacobian.
    pub(super) fn error(&mut self, target: [f64; 3], x: &[f64]) -> Result<[f64; 3], Error> {
        self.kinematics.evaluate_bent(self.robot, x)?;
        let point = self.kinematics.site(self.robot, self.site)?;
        for (row, used) in self.kinematics.rows.chunks_exact_mut(x.len()).zip(self.axes) {
            if !used {
                row.fill(0.0);
            }
        }
        Ok(core::array::from_fn(|k| if self.axes[k] { target[k] - point[k] } else { 0.0 }))
    }

    /// Writes the solution of the linearised problem about `x` to `next`.
    fn nearest(&mut self, error: [f64; 3], regularization: f64, x: &[f64], multipliers: &mut [f64; 3]) {
        let n = x.len();
        let right =
            core::array::from_fn(|k| error[k] + product(&self.kinematics.rows[k * n..(k + 1) * n], x));
        let problem = Nearest {
            preferred: &self.preferred,
            weight: &self.rule.weight,
            bounds: &self.ranges,
            rows: &self.kinematics.rows,
            right,
            regularization,
        };
        problem.solve(&mut self.next, multipliers);
    }

    /// Trace of `J W^-1 J^T`.
    fn trace(&self) -> f64 {
        let weights = self.rule.weight.iter().cycle();
        self.kinematics.rows.iter().zip(weights).map(|(x, w)| x * x / w).sum::<f64>() + f64::MIN_POSITIVE
    }

    /// Moves `x` toward `next`, at most by a stride; returns the largest change before it is limited.
    fn advance(&self, x: &mut [f64]) -> f64 {
        let (mut fraction, mut largest) = (1.0, 0.0_f64);
        for ((next, x), stride) in self.next.iter().zip(x.iter()).zip(&self.strides) {
            let change = (next - x).abs();
            largest = largest.max(change);
            if change * fraction > *stride {
                fraction = stride / change;
            }
        }
        x.iter_mut().zip(&self.next).for_each(|(x, next)| *x += fraction * (next - *x));
        largest
    }
}
