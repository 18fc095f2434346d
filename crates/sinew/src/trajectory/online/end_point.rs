use crate::body::vector::norm;
use crate::body::{IndependentKinematics, Robot};
use crate::error::{Error, check_length, within};
use crate::trajectory::Redundancy;
use crate::trajectory::nearest::Nearest;
use alloc::vec;
use alloc::vec::Vec;

/// Pose of the joints that follows a target of the end point: some steps of damped least squares per control
/// cycle.
///
/// ```text
/// y = argmin 1/2 |p_t - p(x) - J (y - x)|^2 + m/2 |y - r|_W^2   so that   low <= y <= high
/// r = x + s (rest - x),   x <- y
/// ```
///
/// | symbol    | meaning                                                             | unit     |
/// |-----------|---------------------------------------------------------------------|----------|
/// | p, p_t    | end point in the task's axes, its target                             | m        |
/// | x, J      | pose, Jacobian of the end point                                      | rad or m |
/// | W, rest   | weights and preferred pose of the machine's [`Redundancy`]             | 1, rad or m |
/// | m         | damping: 1e-6 of the trace of `J W^-1 J^T`, and more with the error  |          |
/// | s         | fraction by which free joints return to the preferred pose per step     | 1        |
///
/// A target out of reach is followed by the pose nearby whose end point is closest to it.
///
/// # Source
/// `nakamura1986` for the damping; the weighted pseudo-inverse is that of `whitney1969`; the ranges
/// enter as bounds of each step.
#[derive(Debug, Clone)]
pub struct EndPointStep {
    robot: Robot,
    rule: Redundancy,
    site: usize,
    axes: [bool; 3],
    ranges: Vec<[f64; 2]>,
    kinematics: IndependentKinematics,
    preferred: Vec<f64>,
    next: Vec<f64>,
}

/// Steps per call.
const STEPS: usize = 3;
/// Position error at which the steps end, m.
const REACHED: f64 = 1e-9;
/// Fraction of the trace in the damping, and of the error.
const DAMPING: f64 = 1e-6;
const CURVATURE: f64 = 0.3;
/// `s`.
const RETURN: f64 = 1e-3;
/// Largest change of a coordinate in one step, rad or m.
const STRIDE: f64 = 0.1;

impl EndPointStep {
    /// For a site and the axes of the world that are followed, within ranges of the joints: `[joints]`.
    ///
    /// # Errors
    /// As [`Redundancy::validate`]; [`Error::OutOfDomain`] for a site that is not there;
    /// [`Error::WrongLength`].
    pub fn new(
        robot: &Robot,
        rule: &Redundancy,
        site: usize,
        axes: [bool; 3],
        ranges: &[[f64; 2]],
    ) -> Result<Self, Error> {
        rule.validate(robot)?;
        within("site", "an index of a site", site as f64, site < robot.parts().sites.len())?;
        let n = rule.rest.len();
        check_length("ranges", ranges.len(), n)?;
        Ok(Self {
            robot: robot.clone(),
            rule: rule.clone(),
            site,
            axes,
            ranges: ranges.to_vec(),
            kinematics: IndependentKinematics::new(robot),
            preferred: vec![0.0; n],
            next: vec![0.0; n],
        })
    }

    /// The end point in a pose, m.
    ///
    /// # Errors
    /// As [`Reduction::expand`](crate::body::Reduction::expand).
    pub fn position(&mut self, x: &[f64]) -> Result<[f64; 3], Error> {
        self.kinematics.evaluate(&self.robot, x)?;
        Ok(self.robot.site_pose(&self.kinematics.poses, self.site).origin)
    }

    /// Moves a pose toward one whose end point is at the target; returns the distance that is left, m.
    /// Nothing is allocated.
    ///
    /// # Errors
    /// As [`Reduction::expand`](crate::body::Reduction::expand); the pose is unchanged then.
    pub fn step(&mut self, target: [f64; 3], x: &mut [f64]) -> Result<f64, Error> {
        let mut error = self.error(target, x)?;
        for _ in 0..STEPS {
            if norm(error) <= REACHED {
                break;
            }
            self.advance(error, x);
            error = self.error(target, x)?;
        }
        Ok(norm(error))
    }

    /// Position error in the task's axes, m; updates the Jacobian.
    fn error(&mut self, target: [f64; 3], x: &[f64]) -> Result<[f64; 3], Error> {
        self.kinematics.evaluate(&self.robot, x)?;
        let point = self.kinematics.site(&self.robot, self.site)?;
        for (row, used) in self.kinematics.rows.chunks_exact_mut(x.len().max(1)).zip(self.axes) {
            if !used {
                row.fill(0.0);
            }
        }
        Ok(core::array::from_fn(|k| if self.axes[k] { target[k] - point[k] } else { 0.0 }))
    }

    fn advance(&mut self, error: [f64; 3], x: &mut [f64]) {
        let n = x.len();
        let weights = self.rule.weight.iter().cycle();
        let trace =
            self.kinematics.rows.iter().zip(weights).map(|(x, w)| x * x / w).sum::<f64>() + f64::MIN_POSITIVE;
        for ((preferred, x), rest) in self.preferred.iter_mut().zip(&*x).zip(&self.rule.rest) {
            *preferred = x + RETURN * (rest - x);
        }
        let rows = &self.kinematics.rows;
        let along = |k: usize| rows[k * n..(k + 1) * n].iter().zip(&*x).map(|(j, x)| j * x).sum::<f64>();
        let problem = Nearest {
            preferred: &self.preferred,
            weight: &self.rule.weight,
            bounds: &self.ranges,
            rows,
            right: core::array::from_fn(|k| error[k] + along(k)),
            regularization: (DAMPING * trace).max(CURVATURE * norm(error) * libm::sqrt(trace)),
        };
        problem.solve(&mut self.next, &mut [0.0; 3]);
        let largest = self.next.iter().zip(&*x).map(|(next, x)| (next - x).abs()).fold(0.0, f64::max);
        let fraction = if largest > STRIDE { STRIDE / largest } else { 1.0 };
        for (x, next) in x.iter_mut().zip(&self.next) {
            *x += fraction * (next - *x);
        }
    }
}
