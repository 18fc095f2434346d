//! Directions in which the end point can move in a pose.

use crate::body::symmetric::eigen;
use alloc::vec;
use alloc::vec::Vec;

/// The space of velocities `J u`, by the eigenvectors of `J J^T`.
pub(super) struct Directions {
    /// Eigenvalues above a threshold, and their vectors.
    axes: Vec<(f64, [f64; 3])>,
    rows: Vec<f64>,
}

/// Squared ratio of lever lengths below which a direction counts as blocked.
const BLOCKED: f64 = 1e-6;

/// Of a Jacobian, `[3 x joints]`.
pub(super) fn directions(rows: &[f64]) -> Directions {
    let n = rows.len() / 3;
    let product = |a: usize, b: usize| (0..n).map(|j| rows[a * n + j] * rows[b * n + j]).sum::<f64>();
    let mut gram: [f64; 9] = core::array::from_fn(|k| product(k / 3, k % 3));
    let mut vectors = [0.0; 9];
    eigen(&mut gram, &mut vectors, 3);
    let most = (0..3).map(|k| gram[4 * k]).fold(0.0, f64::max);
    let axis = |k: usize| (gram[4 * k], core::array::from_fn(|i| vectors[3 * k + i]));
    let open = |(value, _): &(f64, [f64; 3])| *value > BLOCKED * most && most > 0.0;
    Directions { axes: (0..3).map(axis).filter(open).collect(), rows: rows.to_vec() }
}

impl Directions {
    /// Unit directions that cover the space: both signs of every axis and of the diagonals.
    pub(super) fn all(&self) -> Vec<[f64; 3]> {
        let count = self.axes.len() as u32;
        let mut all = Vec::new();
        for code in 0..3_u32.pow(count) {
            let mut direction = [0.0; 3];
            for (k, (_, axis)) in self.axes.iter().enumerate() {
                let sign = f64::from(code / 3_u32.pow(k as u32) % 3) - 1.0;
                direction.iter_mut().zip(axis).for_each(|(d, a)| *d += sign * a);
            }
            let length = libm::sqrt(direction.iter().map(|x| x * x).sum());
            if length > 0.5 {
                all.push(direction.map(|x| x / length));
            }
        }
        all
    }

    /// Velocity of the joints with least squares that moves the end point along `direction`, as far as it can:
    /// `J^T (J J^T)^+ d`.
    pub(super) fn velocity(&self, direction: [f64; 3]) -> Vec<f64> {
        let n = self.rows.len() / 3;
        let mut velocity = vec![0.0; n];
        for (value, axis) in &self.axes {
            let along: f64 = axis.iter().zip(direction).map(|(a, d)| a * d).sum();
            for (j, velocity) in velocity.iter_mut().enumerate() {
                let lever: f64 = (0..3).map(|k| self.rows[k * n + j] * axis[k]).sum();
                *velocity += lever * along / value;
            }
        }
        velocity
    }

    /// Unit vectors that span the space.
    pub(super) fn basis(&self) -> impl Iterator<Item = [f64; 3]> {
        self.axes.iter().map(|(_, axis)| *axis)
    }
}
