//! Cholesky's factor of a symmetric positive definite matrix (Golub and Van Loan, Matrix Computations, 4.2).

use super::matrix::{Matrix, SHORTER, TALLEST, add_lower_product};
use crate::fit::simd::padded;
use crate::fit::tiles::{View, add_row_of_tiles};
use pulp::{Arch, Simd, WithSimd};

/// Columns of a factor that are computed at a time: whole pairs of the widest vectors.
const PANEL: usize = 32;

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
pub(super) struct Factorise<'a>(pub(super) &'a mut Matrix);

impl Factorise<'_> {
    #[inline(always)]
    pub(super) fn factorise<S: Simd, const TALL: usize>(self, simd: S) -> bool {
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

/// Of `A^-1 = M^T M`, `M = L^-1`: squares of the columns of `M`, a panel of them at a time by forward
/// substitution.
pub(super) struct InverseDiagonal<'a>(pub(super) &'a Matrix);

impl InverseDiagonal<'_> {
    #[inline(always)]
    pub(super) fn compute<S: Simd, const TALL: usize>(self, simd: S) -> Vec<f64> {
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
