//! Linear least squares with few unknowns.

use super::block::Block;
use alloc::vec::Vec;

/// Orthogonal columns and the triangle that made them.
#[derive(Debug, Clone)]
pub(super) struct LeastSquares {
    joints: usize,
    /// `joints` columns of `joints` entries each.
    columns: Vec<f64>,
    /// Upper triangle, row by row.
    triangle: Vec<f64>,
    target: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a -= f b`.
fn subtract(a: &mut [f64], f: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= f * b;
    }
}

impl LeastSquares {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            joints,
            columns: alloc::vec![0.0; joints * joints],
            triangle: alloc::vec![0.0; joints * joints],
            target: alloc::vec![0.0; joints],
        }
    }

    /// `min_x |sum_k x_k r_k - target|^2` over the moment arms `r_k` of the muscles `free`, which are independent.
    ///
    /// Gram and Schmidt's way, each column made orthogonal twice, which is as good as reflections. A column of which
    /// nothing is left gets no part.
    pub(super) fn solve(&mut self, block: &Block, free: &[usize], target: &[f64], x: &mut [f64]) {
        /// Part of a column that is rounding.
        const NOTHING: f64 = 1e-14;
        let (n, count) = (target.len(), free.len().min(self.joints));
        let room = self.joints;
        self.target[..n].copy_from_slice(target);
        for k in 0..count {
            let (done, rest) = self.columns.split_at_mut(k * room);
            let column = &mut rest[..n];
            column.fill(0.0);
            for (joint, arm) in block.row(free[k]) {
                column[joint] = arm;
            }
            let size = libm::sqrt(dot(column, column));
            for i in 0..k {
                self.triangle[i * room + k] = 0.0;
            }
            for _ in 0..2 {
                for (i, other) in done.chunks_exact(room).enumerate() {
                    let f = dot(&other[..n], column);
                    self.triangle[i * room + k] += f;
                    subtract(column, f, &other[..n]);
                }
            }
            let left = libm::sqrt(dot(column, column));
            let inverse = if left > NOTHING * size { 1.0 / left } else { 0.0 };
            column.iter_mut().for_each(|c| *c *= inverse);
            self.triangle[k * room + k] = inverse;
            x[k] = dot(column, &self.target[..n]);
            subtract(&mut self.target[..n], x[k], column);
        }
        for k in (0..count).rev() {
            let row = &self.triangle[k * room..];
            let sum = dot(&row[k + 1..count], &x[k + 1..count]);
            x[k] = (x[k] - sum) * row[k];
        }
    }
}
