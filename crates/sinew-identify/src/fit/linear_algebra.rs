//! Dense symmetric systems through `faer`, on the calling thread so that results do not depend on the number
//! of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, inverse, solve};
use faer::{Mat, Par, Side};

/// Factor `L` of a symmetric positive definite matrix, `A = L L^T`.
pub(crate) struct Cholesky(Mat<f64>);

impl Cholesky {
    /// Factorises the lower triangle of `matrix: [p x p]`; `None` where it is not positive definite.
    pub(crate) fn new(mut matrix: Mat<f64>) -> Option<Self> {
        let scratch = factor::cholesky_in_place_scratch::<f64>(matrix.nrows(), Par::Seq, Default::default());
        let mut buffer = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut buffer);
        factor::cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, stack, Default::default())
            .ok()?;
        Some(Self(matrix))
    }

    /// Solution of `A x = right: [p]`; `None` where it is not finite.
    pub(crate) fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let mut x = Mat::from_fn(right.len(), 1, |row, _| right[row]);
        let mut buffer = MemBuffer::new(solve::solve_in_place_scratch::<f64>(right.len(), 1, Par::Seq));
        solve::solve_in_place(self.0.as_ref(), x.as_mut(), Par::Seq, MemStack::new(&mut buffer));
        let x: Vec<f64> = (0..right.len()).map(|row| x[(row, 0)]).collect();
        x.iter().all(|entry| entry.is_finite()).then_some(x)
    }

    /// Diagonal of `A^-1`: `[p]`.
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        let p = self.0.nrows();
        let mut out = Mat::zeros(p, p);
        let mut buffer = MemBuffer::new(inverse::inverse_scratch::<f64>(p, Par::Seq));
        inverse::inverse(out.as_mut(), self.0.as_ref(), Par::Seq, MemStack::new(&mut buffer));
        (0..p).map(|i| out[(i, i)]).collect()
    }
}

/// Eigenvalues `[p]` and eigenvectors, the columns of `[p x p]`, of the symmetric matrix with this lower
/// triangle; `None` where an entry is not finite.
pub(crate) fn symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let p = matrix.nrows();
    if !(0..p).all(|row| (0..=row).all(|column| matrix[(row, column)].is_finite())) {
        return None;
    }
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let values = eigen.S().column_vector();
    Some(((0..p).map(|i| values[i]).collect(), eigen.U().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: [[f64; 2]; 2]) -> Mat<f64> {
        Mat::from_fn(2, 2, |row, column| rows[row][column])
    }

    #[test]
    fn a_known_matrix_has_its_eigenvalues_inverse_and_solution() {
        let a = matrix([[4.0, 1.0], [1.0, 3.0]]);
        let (mut values, _) = symmetric_eigen(&a).unwrap();
        values.sort_by(f64::total_cmp);
        let root = 5.0_f64.sqrt();
        assert!((values[0] - (7.0 - root) / 2.0).abs() < 1e-12);
        assert!((values[1] - (7.0 + root) / 2.0).abs() < 1e-12);
        let factor = Cholesky::new(a).unwrap();
        let x = factor.solve(&[1.0, 2.0]).unwrap();
        assert!((x[0] - 1.0 / 11.0).abs() < 1e-12 && (x[1] - 7.0 / 11.0).abs() < 1e-12);
        let diagonal = factor.inverse_diagonal();
        assert!((diagonal[0] - 3.0 / 11.0).abs() < 1e-12 && (diagonal[1] - 4.0 / 11.0).abs() < 1e-12);
    }

    #[test]
    fn an_indefinite_matrix_and_numbers_that_are_not_finite_are_refused() {
        assert!(Cholesky::new(matrix([[1.0, 2.0], [2.0, 1.0]])).is_none());
        let bad = matrix([[f64::NAN, 0.0], [0.0, 1.0]]);
        assert!(symmetric_eigen(&bad).is_none());
        assert!(Cholesky::new(bad).and_then(|factor| factor.solve(&[1.0, 1.0])).is_none());
    }
}
