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
