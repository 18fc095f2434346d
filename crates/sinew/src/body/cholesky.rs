//! Cholesky factors of a symmetric positive definite matrix, row by row: `A = L L^T`.

use crate::error::{Error, positive};

/// Replaces the lower triangle of `a`, `[n x n]`, by `L`; the upper one is not read.
///
/// # Errors
/// [`Error::OutOfDomain`] with the first pivot that is not positive.
pub(crate) fn factor(a: &mut [f64], n: usize) -> Result<(), Error> {
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let rest = a[i * n + j] - sum;
            a[i * n + j] = if i == j {
                libm::sqrt(positive("pivot of a mass matrix", rest)?)
            } else {
                rest / a[j * n + j]
            };
        }
    }
    Ok(())
}

/// `b := L^-1 b`.
pub(crate) fn solve_lower(l: &[f64], b: &mut [f64]) {
    let n = b.len();
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| l[i * n + k] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i * n + i];
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
