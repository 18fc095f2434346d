//! Dense symmetric systems on the calling thread: `J^T J`, Cholesky's factor, eigenvalues by Jacobi's rotations.
//!
//! The three products that cost time, `J^T J` and the updates of factor and inverse, are those of `tiles`.

use super::simd::padded;
use super::tiles::{BLOCK, View, add_row_of_tiles};
use pulp::{Arch, Simd, WithSimd};
use std::ops::{Index, IndexMut, Range};

/// Rows of a tile on machines with 32 vector registers, and on those with 16.
const TALLEST: usize = 14;
const SHORTER: usize = 6;

/// Columns of a factor that are computed at a time: whole pairs of the widest vectors.
const PANEL: usize = 32;

/// `[p x p]`, column by column; of a symmetric matrix the lower triangle counts.
#[derive(Debug, Clone)]
pub(crate) struct Matrix {
    size: usize,
    stride: usize,
    entries: Vec<f64>,
}

impl Matrix {
    /// Zeros: `[p x p]`.
    pub(crate) fn zeros(p: usize) -> Self {
        let stride = Self::stride(p);
        Self { size: p, stride, entries: vec![0.0; p * stride] }
    }

    /// `entry(row, column)`: `[p x p]`.
    pub(crate) fn from_fn(p: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut matrix = Self::zeros(p);
        for column in 0..p {
            for row in 0..p {
                matrix[(row, column)] = entry(row, column);
            }
        }
        matrix
    }

    /// Numbers from one column of a `[p x p]` matrix to the next: room for a tile that begins in the last row, and an
    /// odd number of cache lines, so that the same rows of many columns fit the cache.
    pub(crate) fn stride(p: usize) -> usize {
        const LINE: usize = 8;
        ((p + TALLEST).div_ceil(LINE) | 1) * LINE
    }

    /// `p`.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Sets every entry to zero.
    pub(crate) fn clear(&mut self) {
        self.entries.fill(0.0);
    }

    /// Multiplies every entry.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.entries.iter_mut().for_each(|entry| *entry *= factor);
    }

    /// Adds the lower triangle of `J^T J`, `J: [n x p]` row-major, rows of [`Matrix::stride`] that end in zeros.
    pub(crate) fn add_square(&mut self, jacobian: &[f64]) {
        Arch::new().dispatch(AddSquare { jacobian, to: self });
    }

    /// Columns `from..to` on their own, and those behind them.
    fn panel(&mut self, from: usize, to: usize) -> (&mut [f64], &mut [f64]) {
        self.entries[from * self.stride..].split_at_mut((to - from) * self.stride)
    }

    fn column(&self, column: usize) -> &[f64] {
        &self.entries[column * self.stride..][..self.size]
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.entries[column * self.stride + row]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.entries[column * self.stride + row]
    }
}

struct AddSquare<'a> {
    jacobian: &'a [f64],
    to: &'a mut Matrix,
}

impl AddSquare<'_> {
    #[inline(always)]
    fn add<S: Simd, const TALL: usize>(self, simd: S) {
        let Matrix { size, stride, entries } = self.to;
        for block in self.jacobian.chunks(BLOCK * *stride) {
            let rows = View { rows: block, width: *stride, count: block.len() / *stride };
            add_lower_product::<S, TALL>(simd, rows, rows, 0..*size, entries);
        }
    }
}

impl WithSimd for AddSquare<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::REGISTER_COUNT >= 32 { self.add::<S, TALLEST>(simd) } else { self.add::<S, SHORTER>(simd) }
    }
}

/// The lower triangle of `out += left^T right` in the given columns: `out: [columns x right.width]`. Entries above it
/// are left undefined.
#[inline(always)]
fn add_lower_product<S: Simd, const TALL: usize>(
    simd: S,
    left: View<'_, f64>,
    right: View<'_, f64>,
    columns: Range<usize>,
    out: &mut [f64],
) {
    for (top, out) in columns.clone().step_by(TALL).zip(out.chunks_mut(TALL * right.width)) {
        add_row_of_tiles::<S, f64, TALL>(simd, left, top, right, top..columns.end, out);
    }
}

/// `to -= factor from`.
#[inline(always)]
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= factor * from;
    }
}

/// Factor `L` of a symmetric positive definite matrix, `A = L L^T`.
pub(crate) struct Cholesky(Matrix);

impl Cholesky {
    /// Factorises the lower triangle of `matrix: [p x p]`; `None` where it is not positive definite.
    pub(crate) fn new(mut matrix: Matrix) -> Option<Self> {
        Arch::new().dispatch(Factorise(&mut matrix)).then_some(Self(matrix))
    }

    /// Solution of `A x = right: [p]`; `None` where it is not finite.
    pub(crate) fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let mut x = right.to_vec();
        for k in 0..x.len() {
            let column = self.0.column(k);
            let (done, rest) = x.split_at_mut(k + 1);
            done[k] /= column[k];
            subtract(rest, done[k], &column[k + 1..]);
        }
        for k in (0..x.len()).rev() {
            let column = self.0.column(k);
            let behind: f64 = column[k + 1..].iter().zip(&x[k + 1..]).map(|(l, x)| l * x).sum();
            x[k] = (x[k] - behind) / column[k];
        }
        x.iter().all(|entry| entry.is_finite()).then_some(x)
    }

    /// Diagonal of `A^-1`: `[p]`.
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        Arch::new().dispatch(InverseDiagonal(&self.0))
    }
}

/// A panel of columns after the other; the columns behind a panel are updated by one product.
struct Factorise<'a>(&'a mut Matrix);

impl Factorise<'_> {
    #[inline(always)]
    fn factorise<S: Simd, const TALL: usize>(self, simd: S) -> bool {
        let (size, stride) = (self.0.size, self.0.stride);
        let mut negative = vec![0.0; PANEL * stride];
        for start in (0..size).step_by(PANEL) {
            let end = (start + PANEL).min(size);
            let (panel, rest) = self.0.panel(start, end);
            for k in start..end {
                let (done, behind) = panel.split_at_mut((k - start + 1) * stride);
                let column = &mut done[(k - start) * stride..][..size];
                let pivot = column[k];
                if !(pivot > 0.0 && pivot.is_finite()) {
                    return false;
                }
                let inverse = 1.0 / pivot.sqrt();
                column[k..].iter_mut().for_each(|entry| *entry *= inverse);
                for (i, behind) in (k + 1..end).zip(behind.chunks_exact_mut(stride)) {
                    subtract(&mut behind[i..size], column[i], &column[i..]);
                }
            }
            for (negative, entry) in negative.iter_mut().zip(&*panel) {
                *negative = -entry;
            }
            let view = |rows| View { rows, width: stride, count: end - start };
            add_lower_product::<S, TALL>(simd, view(&negative), view(panel), end..size, rest);
        }
        true
    }
}

impl WithSimd for Factorise<'_> {
    type Output = bool;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if S::REGISTER_COUNT >= 32 {
            self.factorise::<S, TALLEST>(simd)
        } else {
            self.factorise::<S, SHORTER>(simd)
        }
    }
}

/// Of `A^-1 = M^T M`, `M = L^-1`: squares of the columns of `M`, a panel of them at a time by forward substitution.
struct InverseDiagonal<'a>(&'a Matrix);

impl InverseDiagonal<'_> {
    #[inline(always)]
    fn compute<S: Simd, const TALL: usize>(self, simd: S) -> Vec<f64> {
        let Matrix { size, stride, entries } = self.0;
        let (size, stride) = (*size, *stride);
        let width = padded(PANEL, TALL);
        let (mut columns, mut negative) = (vec![0.0; PANEL * stride], vec![0.0; PANEL * width]);
        let mut diagonal = Vec::with_capacity(size);
        for first in (0..size).step_by(PANEL) {
            let count = PANEL.min(size - first);
            columns.fill(0.0);
            columns.chunks_exact_mut(stride).take(count).enumerate().for_each(|(c, m)| m[first + c] = 1.0);
            for start in (first..size).step_by(PANEL) {
                let end = (start + PANEL).min(size);
                for (k, negative) in (start..end).zip(negative.chunks_exact_mut(width)) {
                    let factor = &entries[k * stride..][..size];
                    for (m, negative) in columns.chunks_exact_mut(stride).zip(&mut *negative) {
                        m[k] /= factor[k];
                        let known = m[k];
                        *negative = -known;
                        subtract(&mut m[k + 1..end], known, &factor[k + 1..end]);
                    }
                }
                let left = View { rows: &negative, width, count: end - start };
                let right = View { rows: &entries[start * stride..], width: stride, count: end - start };
                for (tile, m) in columns.chunks_mut(TALL * stride).enumerate() {
                    if end < size {
                        add_row_of_tiles::<S, f64, TALL>(simd, left, tile * TALL, right, end..size, m);
                    }
                }
            }
            let square = |m: &[f64]| m[first..size].iter().map(|entry| entry * entry).sum::<f64>();
            diagonal.extend(columns.chunks_exact(stride).take(count).map(square));
        }
        diagonal
    }
}

impl WithSimd for InverseDiagonal<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        if S::REGISTER_COUNT >= 32 {
            self.compute::<S, TALLEST>(simd)
        } else {
            self.compute::<S, SHORTER>(simd)
        }
    }
}

/// Eigenvalues `[p]` and eigenvectors, the columns of `[p x p]`, of the symmetric matrix with this lower triangle, by
/// cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5); `None` where an entry is not finite.
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
                for k in 0..p {
                    (a[(k, i)], a[(k, j)]) = rotate(a[(k, i)], a[(k, j)], cosine, sine);
                    (vectors[(k, i)], vectors[(k, j)]) =
                        rotate(vectors[(k, i)], vectors[(k, j)], cosine, sine);
                }
                for k in 0..p {
                    (a[(i, k)], a[(j, k)]) = rotate(a[(i, k)], a[(j, k)], cosine, sine);
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

#[cfg(test)]
mod tests {
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
                    let square: f64 = (0..n).map(|k| entry(k, row) * entry(k, column)).sum();
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
}
