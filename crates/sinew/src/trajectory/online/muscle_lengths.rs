use crate::body::Robot;
use crate::body::cholesky;
use crate::error::{Error, check_length};
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Pose of the joints that follows target lengths of the muscles: one Gauss-Newton step per control cycle.
///
/// ```text
/// (R^T R + m 1) (y - x) = R^T (l(x) - l_t),    y in the ranges,    x <- y
/// ```
///
/// | symbol | meaning                                   | unit | shape               |
/// |--------|-------------------------------------------|------|---------------------|
/// | l, l_t | lengths and their targets                 | m    | `[muscles]`         |
/// | R      | moment arms `-dl/dq`                      | m    | `[muscles x joints]` |
/// | m      | damping: 1e-4 of the mean of the diagonal | m^2  |                     |
///
/// Lengths that belong to no pose are followed by the pose nearby with the least squared error.
///
/// # Source
/// Textbook: damped Gauss-Newton method.
#[derive(Debug, Clone)]
pub struct MuscleLengthStep {
    body: MuscleDynamics,
    ranges: Vec<[f64; 2]>,
    /// `[joints x joints]`, `[joints]`.
    normal: Vec<f64>,
    change: Vec<f64>,
}

/// `m`, relative.
const DAMPING: f64 = 1e-4;
/// Largest change of a coordinate in one step, rad or m.
const STRIDE: f64 = 0.1;

impl MuscleLengthStep {
    /// Within ranges of the joints: `[joints]`.
    ///
    /// # Errors
    /// As [`MuscleDynamics::new`]; [`Error::WrongLength`].
    pub fn new(robot: &Robot, ranges: &[[f64; 2]]) -> Result<Self, Error> {
        let body = MuscleDynamics::new(robot)?;
        let n = body.joints();
        check_length("ranges", ranges.len(), n)?;
        Ok(Self { body, ranges: ranges.to_vec(), normal: vec![0.0; n * n], change: vec![0.0; n] })
    }

    /// Lengths in a pose, m: `[muscles]`.
    ///
    /// # Errors
    /// As [`MuscleDynamics::evaluate`].
    pub fn lengths(&mut self, x: &[f64]) -> Result<&[f64], Error> {
        self.body.evaluate(x)?;
        Ok(self.body.lengths())
    }

    /// Moves a pose toward one with the target lengths; returns the largest error of a length before the
    /// step, m. Nothing is allocated.
    ///
    /// # Errors
    /// As [`MuscleDynamics::evaluate`]; the pose is unchanged then.
    pub fn step(&mut self, target: &[f64], x: &mut [f64]) -> Result<f64, Error> {
        let n = x.len();
        check_length("muscle lengths", target.len(), self.body.muscles())?;
        self.body.evaluate(x)?;
        self.normal.fill(0.0);
        self.change.fill(0.0);
        let mut largest = 0.0_f64;
        let arms = self.body.moment_arms().chunks_exact(n.max(1));
        for ((row, length), target) in arms.zip(self.body.lengths()).zip(target) {
            let error = length - target;
            largest = largest.max(error.abs());
            for i in 0..n {
                self.change[i] += row[i] * error;
                for j in 0..=i {
                    self.normal[i * n + j] += row[i] * row[j];
                }
            }
        }
        let mean = (0..n).map(|i| self.normal[i * n + i]).sum::<f64>() / n.max(1) as f64;
        for i in 0..n {
            self.normal[i * n + i] += DAMPING * mean + f64::MIN_POSITIVE;
        }
        cholesky::factor(&mut self.normal, n)?;
        cholesky::solve(&self.normal, &mut self.change);
        let most = self.change.iter().fold(0.0_f64, |most, change| most.max(change.abs()));
        let fraction = if most > STRIDE { STRIDE / most } else { 1.0 };
        for ((x, change), [low, high]) in x.iter_mut().zip(&self.change).zip(&self.ranges) {
            *x = (*x + fraction * change).max(*low).min(*high);
        }
        Ok(largest)
    }
}
