//! Products, factors and eigenvalues against their definitions.

use super::cholesky::{Factorise, InverseDiagonal};
use super::matrix::{AddSquare, SHORTER, TALLEST};
use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// `J` of up to 200 rows and 100 columns, `A = J^T J + 1`.
    #[test]
    fn products_factors_and_inverses_are_those_of_the_definitions(p in 1_usize..100, n in 1_usize..200, seed in 0.1_f64..1.0) {
        let entry = |row: usize, column: usize| (seed * (1 + row * p + column) as f64).sin();
        let stride = Matrix::stride(p);
        let mut jacobian = vec![0.0; n * stride];
        for (row, values) in jacobian.chunks_exact_mut(stride).enumerate() {
            values[..p].iter_mut().enumerate().for_each(|(column, value)| *value = entry(row, column));
        }
        let mut a = Matrix::from_fn(p, |row, column| if row == column { 1.0 } else { 0.0 });
        a.add_square(&jacobian);
        for column in 0..p {
            for row in column..p {
                let rows = jacobian.chunks_exact(stride);
                let square: f64 = rows.map(|values| values[row] * values[column]).sum();
                let expected = if row == column { square + 1.0 } else { square };
                prop_assert!((a[(row, column)] - expected).abs() < 1e-12 * n as f64);
            }
        }
        let factor = Cholesky::new(a.clone()).unwrap();
        let diagonal = factor.inverse_diagonal();
        for i in (0..p).step_by(7) {
            let unit: Vec<f64> = (0..p).map(|row| if row == i { 1.0 } else { 0.0 }).collect();
            let x = factor.solve(&unit).unwrap();
            prop_assert!((x[i] - diagonal[i]).abs() < 1e-11);
            for row in 0..p {
                let product: f64 = (0..p).map(|k| a[(row.max(k), row.min(k))] * x[k]).sum();
                prop_assert!((product - unit[row]).abs() < 1e-9, "{product}");
            }
        }
        let (values, vectors) = symmetric_eigen(&a).unwrap();
        for k in (0..p).step_by(5) {
            for row in 0..p {
                let product: f64 = (0..p).map(|i| a[(row.max(i), row.min(i))] * vectors[(i, k)]).sum();
                prop_assert!((product - values[k] * vectors[(row, k)]).abs() < 1e-10 * n as f64);
            }
        }
    }
}

fn matrix(rows: [[f64; 2]; 2]) -> Matrix {
    Matrix::from_fn(2, |row, column| rows[row][column])
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

/// Lower triangles of a sum, of its factor, and the inverse's diagonal, in tiles of `TALL` rows without SIMD.
fn plainly<const TALL: usize>(p: usize, jacobian: &[f64]) -> Vec<f64> {
    let mut matrix = Matrix::from_fn(p, |row, column| if row == column { 1.0 } else { 0.0 });
    AddSquare { jacobian, to: &mut matrix }.add::<_, TALL>(pulp::Scalar);
    let lower = |matrix: &Matrix| {
        (0..p).flat_map(|column| matrix.column(column)[column..].to_vec()).collect::<Vec<f64>>()
    };
    let mut all = lower(&matrix);
    assert!(Factorise(&mut matrix).factorise::<_, TALL>(pulp::Scalar));
    all.extend(lower(&matrix));
    all.extend(InverseDiagonal(&matrix).compute::<_, TALL>(pulp::Scalar));
    all
}

#[test]
fn tiles_of_every_machine_give_the_same() {
    for p in [1, 5, 13, 14, 15, 31, 32, 33, 47, 64, 65, 98] {
        let mut jacobian = vec![0.0; 150 * Matrix::stride(p)];
        for (row, values) in jacobian.chunks_exact_mut(Matrix::stride(p)).enumerate() {
            values[..p]
                .iter_mut()
                .enumerate()
                .for_each(|(i, value)| *value = ((7 * row * p + i) as f64).sin());
        }
        let (short, tall) = (plainly::<SHORTER>(p, &jacobian), plainly::<TALLEST>(p, &jacobian));
        let off = short.iter().zip(&tall).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(short.len() == tall.len() && off < 1e-10, "{p}: {off}");
    }
}
