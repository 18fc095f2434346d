//! Eigenvalues of a symmetric 3 x 3 matrix.

/// Sweeps of the Jacobi method: convergence is quadratic.
const SWEEPS: usize = 12;

/// Eigenvalues and unit eigenvectors, in no particular order, by Jacobi rotations.
pub(super) fn eigen(mut a: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
            let sign = if theta < 0.0 { -1.0 } else { 1.0 };
            let t = sign / (theta.abs() + libm::sqrt(theta * theta + 1.0));
            let c = 1.0 / libm::sqrt(t * t + 1.0);
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                let (x, y) = (vectors[p][k], vectors[q][k]);
                (vectors[p][k], vectors[q][k]) = (c * x - s * y, s * x + c * y);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_orthonormal_and_the_matrix_scales_them() {
        for scale in [1e-6, 1.0, 1e6] {
            for k in 0..100 {
                let x: [f64; 6] = core::array::from_fn(|i| scale * libm::sin(f64::from(k) + 7.0 * i as f64));
                let a = [[x[0], x[1], x[2]], [x[1], x[3], x[4]], [x[2], x[4], x[5]]];
                let (values, vectors) = eigen(a);
                for (value, v) in values.iter().zip(vectors) {
                    for (row, entry) in a.iter().zip(v) {
                        let product: f64 = row.iter().zip(v).map(|(a, v)| a * v).sum();
                        assert!((product - value * entry).abs() < 2e-15 * scale);
                    }
                    assert!((v.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-13);
                }
            }
        }
    }
}
