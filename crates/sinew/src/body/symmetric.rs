//! Eigenvalues of a symmetric matrix.

/// Sweeps of the Jacobi method: convergence is quadratic.
const SWEEPS: usize = 14;

/// Replaces the diagonal of `a`, `[n x n]`, by its eigenvalues, in no particular order, and writes the unit
/// eigenvectors, one in each row of `vectors`, by Jacobi rotations.
pub(crate) fn eigen(a: &mut [f64], vectors: &mut [f64], n: usize) {
    vectors.fill(0.0);
    (0..n).for_each(|k| vectors[k * n + k] = 1.0);
    for _ in 0..SWEEPS {
        for (p, q) in (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q))) {
            if a[p * n + q] == 0.0 {
                continue;
            }
            let theta = 0.5 * (a[q * n + q] - a[p * n + p]) / a[p * n + q];
            let sign = if theta < 0.0 { -1.0 } else { 1.0 };
            let t = sign / (theta.abs() + libm::sqrt(theta * theta + 1.0));
            let c = 1.0 / libm::sqrt(t * t + 1.0);
            let s = t * c;
            let rotate = |x: f64, y: f64| (c * x - s * y, s * x + c * y);
            for row in a.chunks_exact_mut(n) {
                (row[p], row[q]) = rotate(row[p], row[q]);
            }
            for k in 0..n {
                (a[p * n + k], a[q * n + k]) = rotate(a[p * n + k], a[q * n + k]);
                (vectors[p * n + k], vectors[q * n + k]) = rotate(vectors[p * n + k], vectors[q * n + k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;
    use alloc::vec::Vec;

    #[test]
    fn eigenvectors_are_orthonormal_and_the_matrix_scales_them() {
        for (n, scale, k) in (0..300).map(|k| (1 + k % 10, [1e-6, 1.0, 1e6][k / 100], k as f64)) {
            let entry = |i: usize, j: usize| scale * libm::sin(k + 7.0 * (i.max(j) * 10 + i.min(j)) as f64);
            let a: Vec<f64> = (0..n * n).map(|at| entry(at / n, at % n)).collect();
            let (mut values, mut vectors) = (a.clone(), vec![0.0; n * n]);
            eigen(&mut values, &mut vectors, n);
            for (row, v) in vectors.chunks_exact(n).enumerate() {
                let value = values[row * n + row];
                for (row, entry) in a.chunks_exact(n).zip(v) {
                    let product: f64 = row.iter().zip(v).map(|(a, v)| a * v).sum();
                    assert!(
                        (product - value * entry).abs() < 1e-14 * scale,
                        "{n}: {product} {value} {entry}"
                    );
                }
                assert!((v.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-13);
            }
        }
    }
}
