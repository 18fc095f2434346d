//! The normal matrix of a tall least-squares problem, block of rows by block of rows.

use crate::Error;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};

/// Accumulates `A = J^T W J` of a Jacobian that never exists as a whole.
///
/// ```text
/// A += sum over the rows j of a block:  w j j^T
/// ```
///
/// Only the lower triangle is computed. The sum runs in the order in which blocks arrive, on the calling
/// thread: callers with many problems use one `Gram` per thread, callers with one problem use one per chunk
/// of rows and [`merge`](Self::merge) them in order, and either way the result does not depend on the number
/// of threads.
///
/// The gradient comes for free: append the residual as the last column, then the last row of `A` holds
/// `J^T W e` and its corner `e^T W e`.
///
/// # Shapes
///
/// blocks: `[rows x p]` row-major; weights: `[rows]`. Blocks of about 512 rows keep the block in the second
/// level cache; fewer than 64 rows waste time.
///
/// # Example
///
/// ```
/// use sinew_identify::fit::gram::Gram;
///
/// let mut gram = Gram::new(2);
/// gram.accumulate(&[1.0, 2.0, 3.0, 4.0])?;
/// assert_eq!(gram.get(1, 1), 20.0);
/// assert_eq!(gram.get(0, 1), 14.0);
/// # Ok::<(), sinew_identify::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Gram {
    lower: Mat<f64>,
    rows: usize,
    scaled: Vec<f64>,
}

impl Gram {
    /// An empty sum for `p` parameters.
    #[must_use]
    pub fn new(p: usize) -> Self {
        Self { lower: Mat::zeros(p, p), rows: 0, scaled: Vec::new() }
    }

    /// Number of parameters `p`.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.lower.nrows()
    }

    /// Rows accumulated so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Forgets everything but the number of parameters and keeps the memory.
    pub fn clear(&mut self) {
        self.lower.fill(0.0);
        self.rows = 0;
    }

    /// Adds the rows of `block`, `[rows x p]` row-major.
    ///
    /// # Errors
    ///
    /// [`Error::Samples`] if the length of `block` is no multiple of `p`.
    pub fn accumulate(&mut self, block: &[f64]) -> Result<(), Error> {
        let rows = self.rows_of(block)?;
        add_lower(&mut self.lower, block, block, rows);
        self.rows += rows;
        Ok(())
    }

    /// Adds the rows of `block`, each `weights[row]` times; weights may be negative or zero.
    ///
    /// # Errors
    ///
    /// [`Error::Samples`] if `block` is not `weights.len()` rows of `p`.
    pub fn accumulate_weighted(&mut self, block: &[f64], weights: &[f64]) -> Result<(), Error> {
        let rows = self.rows_of(block)?;
        if rows != weights.len() {
            return Err(Error::samples("weights", format!("{rows}, one a row"), &weights.len()));
        }
        let Self { lower, scaled, .. } = self;
        scaled.clear();
        let p = lower.nrows().max(1);
        for (row, weight) in block.chunks_exact(p).zip(weights) {
            scaled.extend(row.iter().map(|entry| weight * entry));
        }
        add_lower(lower, block, scaled, rows);
        self.rows += rows;
        Ok(())
    }

    /// Adds another sum over the same parameters.
    ///
    /// # Errors
    ///
    /// [`Error::Samples`] if `other` has another number of parameters.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.parameters() != other.parameters() {
            let expected = format!("{}, as in the sum it is added to", self.parameters());
            return Err(Error::samples("parameters", expected, &other.parameters()));
        }
        self.lower += &other.lower;
        self.rows += other.rows;
        Ok(())
    }

    /// CandidateRecipe `(row, column)` of the symmetric matrix; NaN outside it.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let (row, column) = (row.max(column), row.min(column));
        if row < self.parameters() { self.lower[(row, column)] } else { f64::NAN }
    }

    /// The lower triangle, `[p x p]`, zeros above the diagonal.
    #[must_use]
    pub fn lower(&self) -> MatRef<'_, f64> {
        self.lower.as_ref()
    }

    fn rows_of(&self, block: &[f64]) -> Result<usize, Error> {
        let p = self.parameters();
        let fits = if p == 0 { block.is_empty() } else { block.len().is_multiple_of(p) };
        if !fits {
            return Err(Error::samples("block", format!("a multiple of {p} numbers"), &block.len()));
        }
        Ok(block.len().checked_div(p).unwrap_or(0))
    }
}

/// `lower += left^T right`, lower triangle only.
fn add_lower(lower: &mut Mat<f64>, left: &[f64], right: &[f64], rows: usize) {
    let p = lower.nrows();
    let left = MatRef::from_row_major_slice(left, rows, p);
    let right = MatRef::from_row_major_slice(right, rows, p);
    matmul(
        lower,
        BlockStructure::TriangularLower,
        Accum::Add,
        left.transpose(),
        BlockStructure::Rectangular,
        right,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(block: &[f64], weights: &[f64], p: usize, row: usize, column: usize) -> f64 {
        block.chunks_exact(p).zip(weights).map(|(j, w)| w * j[row] * j[column]).sum()
    }

    proptest! {
        #[test]
        fn blocks_of_any_size_sum_to_the_product_of_the_whole(
            p in 1_usize..40, rows in 1_usize..90, cut in 0.0_f64..1.0, seed in 0_u64..1000
        ) {
            let noise = |i: usize| ((i as f64 + 1.3) * (seed as f64 + 0.7)).sin();
            let block: Vec<f64> = (0..rows * p).map(noise).collect();
            let weights: Vec<f64> = (0..rows).map(|i| 3.0 * noise(7 * i + 1)).collect();
            let at = (cut * rows as f64) as usize;
            let mut gram = Gram::new(p);
            let mut rest = Gram::new(p);
            gram.accumulate_weighted(&block[..at * p], &weights[..at]).unwrap();
            rest.accumulate_weighted(&block[at * p..], &weights[at..]).unwrap();
            gram.merge(&rest).unwrap();
            prop_assert_eq!(gram.rows(), rows);
            for (row, column) in [(0, 0), (p - 1, 0), (p / 2, p - 1), (p - 1, p - 1)] {
                let expected = naive(&block, &weights, p, row, column);
                prop_assert!((gram.get(row, column) - expected).abs() < 1e-12 * rows as f64);
            }
        }
    }

    #[test]
    fn unit_weights_change_nothing() {
        let block: Vec<f64> = (0..70 * 13).map(|i| f64::from(i).cos()).collect();
        let (mut plain, mut weighted) = (Gram::new(13), Gram::new(13));
        plain.accumulate(&block).unwrap();
        weighted.accumulate_weighted(&block, &[1.0; 70]).unwrap();
        assert_eq!(plain.lower(), weighted.lower());
    }

    #[test]
    fn a_block_that_is_not_whole_rows_is_refused_by_name() {
        let mut gram = Gram::new(3);
        let error = gram.accumulate(&[1.0; 7]).unwrap_err().to_string();
        assert!(error.contains("block") && error.contains("multiple of 3") && error.contains('7'), "{error}");
        assert!(gram.accumulate_weighted(&[1.0; 6], &[1.0; 3]).is_err());
        assert!(gram.merge(&Gram::new(2)).is_err());
        assert!(Gram::new(0).accumulate(&[1.0]).is_err());
        assert!(Gram::new(0).accumulate(&[]).is_ok());
        assert!(gram.get(3, 0).is_nan());
    }
}
