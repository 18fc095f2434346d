//! Eigenvalues of a symmetric matrix by Jacobi's rotations.

use super::Matrix;

/// Eigenvalues `[p]` and eigenvectors, the columns of `[p x p]`, of the symmetric matrix with this lower
/// triangle, by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5); `None` where an entry
/// is not finite.
pub(crate) fn symmetric_eigen(matrix: &Matrix) -> Option<(Vec<f64>, Matrix)> {
    /// Sweeps over all pairs; convergence is quadratic and takes six to ten.
    const SWEEPS: usize = 60;
    let p = matrix.size();
    let mut a = Matrix::from_fn(p, |row, column| matrix[(row.max(column), row.min(column))]);
    if !(0..p).all(|column| a.column(column).iter().all(|entry| entry.is_finite())) {
        return None;
    }
    let mut vectors = Matrix::from_fn(p, |row, column| if row == column { 1.0 } else { 0.0 });
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for i in 0..p {
            for j in i + 1..p {
                let (off, d, e) = (a[(j, i)], a[(i, i)], a[(j, j)]);
                if off.abs() <= f64::EPSILON * (d.abs() * e.abs()).sqrt() {
                    continue;
                }
                rotated = true;
                let ratio = (e - d) / (2.0 * off);
                let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                for matrix in [&mut a, &mut vectors] {
                    let (left, right) = matrix.two_columns(i, j);
                    for (x, y) in left.iter_mut().zip(right) {
                        (*x, *y) = rotate(*x, *y, cosine, sine);
                    }
                }
                for column in a.columns() {
                    (column[i], column[j]) = rotate(column[i], column[j], cosine, sine);
                }
            }
        }
        if !rotated {
            break;
        }
    }
    Some(((0..p).map(|i| a[(i, i)]).collect(), vectors))
}

fn rotate(x: f64, y: f64, cosine: f64, sine: f64) -> (f64, f64) {
    (cosine * x - sine * y, sine * x + cosine * y)
}
