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
    let open = |(value, _): &(f64, [f64; 3])| *value > BLOCKED * most;
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

    /// Velocity of the joints with least squares that moves the end point along `direction`, as far as it
    /// can: `J^T (J J^T)^+ d`.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Rows x, y and z of three joints; the third moves the end point as the first two together.
    const PLANAR: [f64; 9] = [0.5, 0.2, 0.7, -0.1, 0.4, 0.3, 0.3, -0.6, -0.3];

    #[test]
    fn a_direction_across_all_columns_is_not_among_those_in_which_the_end_point_moves() {
        let across = [-0.1 * -0.6 - 0.3 * 0.4, 0.3 * 0.2 - 0.5 * -0.6, 0.5 * 0.4 - -0.1 * 0.2];
        // Machines from instruments to cranes have the same directions.
        for size in [1e-3, 1.0, 30.0] {
            let found = directions(&PLANAR.map(|x| size * x));
            assert_eq!(found.basis().count(), 2, "{size}");
            assert!(found.basis().all(|axis| dot(&axis, &across).abs() < 7e-17), "{size}");
        }
        assert_eq!(directions(&[0.0; 9]).all().len(), 0);
    }

    #[test]
    fn both_signs_of_every_axis_and_diagonal_are_there_once() {
        let diagonal = [2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0];
        for (rows, count) in [(&diagonal[..], 26), (&PLANAR[..], 8), (&[0.0, 0.5, 0.0][..], 2)] {
            let found = directions(rows);
            let all = found.all();
            assert_eq!(all.len(), count);
            for (k, a) in all.iter().enumerate() {
                let basis: Vec<f64> = found.basis().map(|axis| dot(&axis, a)).collect();
                let used = basis.iter().filter(|fraction| fraction.abs() > 1e-12).count() as f64;
                // Equal fractions of the axes that it uses, of length one together.
                assert!(basis.iter().all(
                    |fraction| fraction.abs() < 1e-12 || (fraction * fraction * used - 1.0).abs() < 3e-15
                ));
                assert!((dot(a, a) - 1.0).abs() < 5e-16);
                assert!(all[..k].iter().all(|b| dot(a, b) < 1.0 - 1e-2));
                assert!(all.iter().any(|b| (dot(a, b) + 1.0).abs() < 5e-16));
            }
        }
    }

    #[test]
    fn the_velocity_of_two_joints_is_that_of_the_normal_equations() {
        let rows = [0.5, 0.2, -0.1, 0.4, 0.3, -0.6];
        let found = directions(&rows);
        let column = |j: usize| [rows[j], rows[2 + j], rows[4 + j]];
        let (a, b) = (column(0), column(1));
        let (aa, ab, bb) = (dot(&a, &a), dot(&a, &b), dot(&b, &b));
        for direction in [[1.0, 0.0, 0.0], [0.0, -2.0, 0.5], [0.3, 0.4, 0.9]] {
            let (ad, bd) = (dot(&a, &direction), dot(&b, &direction));
            let determinant = aa * bb - ab * ab;
            let expected = [(bb * ad - ab * bd) / determinant, (aa * bd - ab * ad) / determinant];
            for (got, expected) in found.velocity(direction).iter().zip(expected) {
                assert!((got - expected).abs() < 4e-16, "{got} {expected}");
            }
        }
    }

    #[test]
    fn of_all_velocities_that_move_the_end_point_alike_it_is_the_least() {
        let found = directions(&PLANAR);
        // (1, 1, -1) moves nothing: the least velocity has no part of it.
        for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let velocity = found.velocity(direction);
            assert!(dot(&velocity, &[1.0, 1.0, -1.0]).abs() < 2e-16);
            let moved: Vec<f64> = PLANAR.chunks_exact(3).map(|row| dot(row, &velocity)).collect();
            // What is left of the direction cannot be moved along.
            let left: Vec<f64> = direction.iter().zip(&moved).map(|(d, m)| d - m).collect();
            assert!(found.basis().all(|axis| dot(&axis, &left).abs() < 7e-16));
        }
    }
}
