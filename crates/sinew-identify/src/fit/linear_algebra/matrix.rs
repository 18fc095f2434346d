//! Square matrices, and the sum `J^T J`.

use crate::fit::tiles::{BLOCK, View, add_row_of_tiles};
use pulp::{Arch, Simd, WithSimd};
use std::ops::{Index, IndexMut, Range};

/// Rows of a tile on machines with 32 vector registers, and on those with 16.
pub(super) const TALLEST: usize = 14;
pub(super) const SHORTER: usize = 6;

/// `[p x p]`, column by column; of a symmetric matrix the lower triangle counts.
#[derive(Debug, Clone)]
pub(crate) struct Matrix {
    pub(super) size: usize,
    pub(super) stride: usize,
    pub(super) entries: Vec<f64>,
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

    /// Numbers from one column of a `[p x p]` matrix to the next: room for a tile that begins in the last
    /// row, and an odd number of cache lines, so that the same rows of many columns fit the cache.
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

    /// Adds the lower triangle of `J^T J`, `J: [n x p]` row-major, rows of [`Matrix::stride`] that end in
    /// zeros.
    pub(crate) fn add_square(&mut self, jacobian: &[f64]) {
        Arch::new().dispatch(AddSquare { jacobian, to: self });
    }

    /// Columns `from..to` on their own, and those behind them.
    pub(super) fn panel(&mut self, from: usize, to: usize) -> (&mut [f64], &mut [f64]) {
        self.entries[from * self.stride..].split_at_mut((to - from) * self.stride)
    }

    /// Two columns, `i < j`.
    pub(super) fn two_columns(&mut self, i: usize, j: usize) -> (&mut [f64], &mut [f64]) {
        let size = self.size;
        let (from_i, from_j) = self.panel(i, j);
        (&mut from_i[..size], &mut from_j[..size])
    }

    /// All columns, each with the room behind it.
    pub(super) fn columns(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.entries.chunks_exact_mut(self.stride)
    }

    pub(super) fn column(&self, column: usize) -> &[f64] {
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

pub(super) struct AddSquare<'a> {
    pub(super) jacobian: &'a [f64],
    pub(super) to: &'a mut Matrix,
}

impl AddSquare<'_> {
    #[inline(always)]
    pub(super) fn add<S: Simd, const TALL: usize>(self, simd: S) {
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

/// The lower triangle of `out += left^T right` in the given columns: `out: [columns x right.width]`. Entries
/// above it are left undefined.
#[inline(always)]
pub(super) fn add_lower_product<S: Simd, const TALL: usize>(
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
