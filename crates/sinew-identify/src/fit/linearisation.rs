//! The normal equations of a sum of squares at one point.

use super::linear_algebra::Matrix;

/// A problem linearised at one `theta`.
#[derive(Debug, Clone)]
pub(crate) struct Linearisation {
    /// `r^T W r`.
    pub squares: f64,
    /// `J^T W r`: `[p]`.
    pub gradient: Vec<f64>,
    /// Lower triangle of `J^T W J`: `[p x p]`.
    pub normal: Matrix,
}

impl Linearisation {
    /// Zeros for `p` parameters.
    pub(crate) fn zeros(p: usize) -> Self {
        Self { squares: 0.0, gradient: vec![0.0; p], normal: Matrix::zeros(p) }
    }

    /// Sets everything to zero.
    pub(crate) fn clear(&mut self) {
        self.squares = 0.0;
        self.gradient.fill(0.0);
        self.normal.clear();
    }

    /// Divides everything by `count`: from a sum over samples to a mean.
    pub(crate) fn divide(&mut self, count: f64) {
        self.squares /= count;
        self.gradient.iter_mut().for_each(|g| *g /= count);
        self.normal.scale(1.0 / count);
    }
}
