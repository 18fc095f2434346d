//! Perpendicular vectors and determinants of a few short vectors.

use alloc::vec::Vec;

/// Pivots below this part of the largest entry count as zero.
const LEAST_PIVOT: f64 = 1e-11;

/// Unit vector perpendicular to `n - 1` unit rows of length `n`, by elimination with full pivoting, which
/// overwrites the rows (three by their cross product); `false` where they are dependent.
pub(super) fn null_vector(rows: &mut [f64], columns: &mut [usize], normal: &mut [f64]) -> bool {
    let n = normal.len();
    if let ([a, b, c, d, e, f], [x, y, z]) = (&*rows, &mut *normal) {
        (*x, *y, *z) = (b * f - c * e, c * d - a * f, a * e - b * d);
        return normalise(normal);
    }
    let count = n - 1;
    columns.iter_mut().enumerate().for_each(|(k, column)| *column = k);
    for i in 0..count {
        let (mut row, mut column, mut most) = (i, i, 0.0);
        for r in i..count {
            for c in i..n {
                let entry = rows[r * n + columns[c]].abs();
                if entry > most {
                    (row, column, most) = (r, c, entry);
                }
            }
        }
        if most <= LEAST_PIVOT {
            return false;
        }
        columns.swap(i, column);
        if row != i {
            (0..n).for_each(|c| rows.swap(i * n + c, row * n + c));
        }
        let pivot = rows[i * n + columns[i]];
        for r in i + 1..count {
            let factor = rows[r * n + columns[i]] / pivot;
            for &c in &columns[i..] {
                rows[r * n + c] -= factor * rows[i * n + c];
            }
        }
    }
    normal[columns[count]] = 1.0;
    for i in (0..count).rev() {
        let rest: f64 = columns[i + 1..].iter().map(|&c| rows[i * n + c] * normal[c]).sum();
        normal[columns[i]] = -rest / rows[i * n + columns[i]];
    }
    normalise(normal)
}

/// Scales to unit length; `false` for a vector that is too short.
fn normalise(vector: &mut [f64]) -> bool {
    let length = libm::sqrt(vector.iter().map(|x| x * x).sum());
    vector.iter_mut().for_each(|x| *x /= length);
    length > LEAST_PIVOT
}

/// `n - 1` orthonormal rows perpendicular to a unit normal: the other rows of a Householder reflection.
pub(super) fn plane_basis(normal: &[f64]) -> Vec<f64> {
    let n = normal.len();
    let most = (0..n).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let sign = if normal[most] < 0.0 { -1.0 } else { 1.0 };
    let mut mirror = normal.to_vec();
    mirror[most] += sign;
    let square: f64 = mirror.iter().map(|x| x * x).sum();
    let row = |i: usize| {
        let mirror = &mirror;
        (0..n).map(move |j| if i == j { 1.0 } else { 0.0 } - 2.0 * mirror[i] * mirror[j] / square)
    };
    (0..n).filter(|&i| i != most).flat_map(row).collect()
}

/// Determinant of a square matrix, which is overwritten.
pub(super) fn determinant(a: &mut [f64], n: usize) -> f64 {
    let mut product = 1.0;
    for i in 0..n {
        let row = (i..n).max_by(|&r, &s| a[r * n + i].abs().total_cmp(&a[s * n + i].abs())).unwrap_or(i);
        if row != i {
            (0..n).for_each(|c| a.swap(i * n + c, row * n + c));
            product = -product;
        }
        let pivot = a[i * n + i];
        if pivot == 0.0 {
            return 0.0;
        }
        product *= pivot;
        for r in i + 1..n {
            let factor = a[r * n + i] / pivot;
            for c in i..n {
                a[r * n + c] -= factor * a[i * n + c];
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use alloc::vec;

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    fn unit(random: &mut Random, n: usize) -> Vec<f64> {
        let vector: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let length = libm::sqrt(dot(&vector, &vector));
        vector.iter().map(|x| x / length).collect()
    }

    #[test]
    fn the_null_vector_is_of_unit_length_and_perpendicular_to_all_rows() {
        let mut random = Random::new(11);
        for n in 1..7 {
            let oblique: Vec<f64> = (1..n).flat_map(|_| unit(&mut random, n)).collect();
            // One entry beside the diagonal in each row: without pivoting the first pivot is zero.
            let mut nested = vec![0.0; (n - 1) * n];
            (0..n - 1).for_each(|i| nested[i * n + (i + 1) % n] = 1.0);
            for rows in [oblique, nested] {
                let (mut columns, mut normal) = (vec![0; n], vec![0.0; n]);
                assert!(null_vector(&mut rows.clone(), &mut columns, &mut normal));
                assert!((dot(&normal, &normal) - 1.0).abs() < 4e-16, "{n}");
                assert!(rows.chunks_exact(n).all(|row| dot(row, &normal).abs() < 2e-16), "{n}");
            }
        }
    }

    #[test]
    fn rows_that_depend_on_each_other_have_no_single_null_vector() {
        for n in 3..6 {
            let mut rows = vec![0.0; (n - 1) * n];
            for row in rows.chunks_exact_mut(n) {
                (row[0], row[n - 1]) = (0.6, -0.8);
            }
            assert!(!null_vector(&mut rows, &mut vec![0; n], &mut vec![0.0; n]), "{n}");
        }
    }

    #[test]
    fn the_basis_of_a_plane_is_orthonormal_and_perpendicular_to_its_normal() {
        let mut random = Random::new(12);
        for n in 2..7 {
            let axis =
                |k: usize, sign: f64| (0..n).map(|j| if j == k { sign } else { 0.0 }).collect::<Vec<f64>>();
            // The axes in both directions: a mirror of the wrong sign has no length there.
            let mut normals: Vec<Vec<f64>> = (0..n).flat_map(|k| [axis(k, 1.0), axis(k, -1.0)]).collect();
            normals.extend((0..10).map(|_| unit(&mut random, n)));
            for normal in normals {
                let basis = plane_basis(&normal);
                assert_eq!(basis.len(), (n - 1) * n);
                for (i, row) in basis.chunks_exact(n).enumerate() {
                    assert!(dot(row, &normal).abs() < 3e-16);
                    for (j, other) in basis.chunks_exact(n).enumerate() {
                        let expected = if i == j { 1.0 } else { 0.0 };
                        assert!((dot(row, other) - expected).abs() < 3e-16);
                    }
                }
            }
        }
    }

    /// By the first row.
    fn expansion(a: &[f64], n: usize) -> f64 {
        if n == 0 {
            return 1.0;
        }
        let minor = |k: usize| -> Vec<f64> {
            let rest = a[n..].iter().enumerate().filter(|(i, _)| i % n != k);
            rest.map(|(_, x)| *x).collect()
        };
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        (0..n).map(|k| sign(k) * a[k] * expansion(&minor(k), n - 1)).sum()
    }

    #[test]
    fn the_determinant_is_that_of_the_expansion_by_rows() {
        let mut random = Random::new(13);
        for n in 1..6 {
            for _ in 0..5 {
                let a: Vec<f64> = (0..n * n).map(|_| random.normal()).collect();
                let expected = expansion(&a, n);
                assert!((determinant(&mut a.clone(), n) - expected).abs() < 4e-15, "{n}");
            }
        }
        // Every order of four rows: one entry per row and column, so that a wrong row is a pivot of zero.
        let mut signs = [0; 3];
        for code in 0..256_usize {
            let columns = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
            let mut a = [0.0; 16];
            (0..4).for_each(|i| a[4 * i + columns[i]] = 1.0 + i as f64);
            let (expected, got) = (expansion(&a, 4), determinant(&mut a, 4));
            assert!((got - expected).abs() < 1e-15, "{columns:?}");
            signs[(1.0 + expected / 24.0) as usize] += 1;
        }
        assert_eq!(signs, [12, 232, 12]);
    }
}
