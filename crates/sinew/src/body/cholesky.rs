//! Cholesky factors of a symmetric positive definite matrix, row by row: `A = L L^T`.

use crate::error::{Error, positive};

/// Replaces the lower triangle of `a`, `[n x n]`, by `L`; the upper one is not read.
///
/// # Errors
/// [`Error::OutOfDomain`] with the first pivot that is not positive.
pub(crate) fn factor(a: &mut [f64], n: usize) -> Result<(), Error> {
    for i in 0..n {
        let (above, rest) = a.split_at_mut(i * n);
        let row = &mut rest[..=i];
        for (j, other) in above.chunks_exact(n).enumerate() {
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        row[i] = libm::sqrt(positive("pivot of a mass matrix", row[i] - dot(&row[..i], &row[..i]))?);
    }
    Ok(())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `b := L^-1 b`.
pub(crate) fn solve_lower(l: &[f64], b: &mut [f64]) {
    let n = b.len();
    for i in 0..n {
        let row = &l[i * n..=i * n + i];
        b[i] = (b[i] - dot(&row[..i], &b[..i])) / row[i];
    }
}

/// `b := A^-1 b` with the factor of `A`.
pub(crate) fn solve(l: &[f64], b: &mut [f64]) {
    solve_lower(l, b);
    solve_upper(l, b);
}

/// `b := L^-T b`.
pub(crate) fn solve_upper(l: &[f64], b: &mut [f64]) {
    let n = b.len();
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i * n + i];
    }
}
