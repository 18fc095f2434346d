//! Moment arms muscle by muscle, dense or sparse, and one group's problem.

use super::scalar::Scalar;

/// The rows of the matrix `R` of one group of joints.
pub(super) trait Rows: Copy {
    /// Joints and arms of a muscle, joints ascending.
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone;

    /// Number of joints.
    fn joints(self) -> usize;

    /// `R_i x`.
    #[inline(always)]
    fn dot<S: Scalar>(self, muscle: usize, x: &[S]) -> S {
        self.row(muscle).fold(S::ZERO, |sum, (joint, arm)| sum + x[joint] * S::from(arm))
    }

    /// `residual -= R^T F`, and the magnitudes of the terms added to `scale`.
    #[inline(always)]
    fn subtract_torque<S: Scalar>(self, tension: &[S], residual: &mut [S], scale: &mut [f64]) {
        for (muscle, tension) in tension.iter().enumerate() {
            for (joint, arm) in self.row(muscle) {
                let torque = *tension * S::from(arm);
                residual[joint] -= torque;
                scale[joint] += torque.rounded().abs();
            }
        }
    }

    /// `h := sum_i f_i R_i^T R_i` in the upper triangle.
    #[inline(always)]
    fn weigh<S: Scalar>(self, f: impl Iterator<Item = f64>, h: &mut [S]) {
        let n = self.joints();
        h.fill(S::ZERO);
        for (muscle, f) in f.enumerate().filter(|(_, f)| *f != 0.0) {
            let mut rest = self.row(muscle);
            while let Some((joint, arm)) = rest.clone().next() {
                let f = S::from(f) * S::from(arm);
                for (other, second) in rest.clone() {
                    h[joint * n + other] += f * S::from(second);
                }
                rest.next();
            }
        }
    }
}

/// Every arm, row by row. `N` is the number of joints where the compiler knows it, otherwise 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dense<'a, const N: usize> {
    pub(super) joints: usize,
    pub(super) arms: &'a [f64],
}

impl<'a, const N: usize> Dense<'a, N> {
    #[inline(always)]
    fn arms(self, muscle: usize) -> &'a [f64] {
        &self.arms[muscle * self.joints()..][..self.joints()]
    }
}

impl<const N: usize> Rows for Dense<'_, N> {
    #[inline(always)]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.arms(muscle).iter().copied().enumerate()
    }

    #[inline(always)]
    fn joints(self) -> usize {
        if N > 0 { N } else { self.joints }
    }

    #[inline(always)]
    fn dot<S: Scalar>(self, muscle: usize, x: &[S]) -> S {
        dot(&x[..self.joints()], self.arms(muscle))
    }

    #[inline(always)]
    fn subtract_torque<S: Scalar>(self, tension: &[S], residual: &mut [S], scale: &mut [f64]) {
        let n = self.joints();
        if N == 0 {
            return subtract(self.arms, tension, &mut residual[..n], &mut scale[..n]);
        }
        let (mut sums, mut sizes) = ([S::ZERO; N], [0.0; N]);
        sums.copy_from_slice(&residual[..n]);
        sizes.copy_from_slice(&scale[..n]);
        subtract(self.arms, tension, &mut sums, &mut sizes);
        residual[..n].copy_from_slice(&sums);
        scale[..n].copy_from_slice(&sizes);
    }

    #[inline(always)]
    fn weigh<S: Scalar>(self, f: impl Iterator<Item = f64>, h: &mut [S]) {
        let n = self.joints();
        h.fill(S::ZERO);
        if N == 0 {
            return add_outer_products(self.arms, n, f.map(|f| (f != 0.0).then_some(f)), h);
        }
        let mut sums = [[S::ZERO; N]; N];
        // For few joints, a muscle is quicker added than asked for.
        add_outer_products(self.arms, n, f.map(Some), sums.as_flattened_mut());
        h[..n * n].copy_from_slice(sums.as_flattened());
    }
}

/// Sums of [`Rows::subtract_torque`], in registers where their number is known to the compiler.
#[inline(always)]
fn subtract<S: Scalar>(arms: &[f64], tension: &[S], residual: &mut [S], scale: &mut [f64]) {
    let n = residual.len();
    for (row, tension) in arms.chunks_exact(n).zip(tension) {
        for j in 0..n {
            let torque = *tension * S::from(row[j]);
            residual[j] -= torque;
            scale[j] += torque.rounded().abs();
        }
    }
}

/// Sums of [`Rows::weigh`], likewise.
#[inline(always)]
fn add_outer_products<S: Scalar>(arms: &[f64], n: usize, f: impl Iterator<Item = Option<f64>>, h: &mut [S]) {
    for (row, f) in arms.chunks_exact(n).zip(f) {
        let Some(f) = f else { continue };
        for i in 0..n {
            let f = S::from(f) * S::from(row[i]);
            for j in i..n {
                h[i * n + j] += f * S::from(row[j]);
            }
        }
    }
}

/// Sum of products, several at a time.
#[inline(always)]
pub(super) fn dot<S: Scalar, T: Copy + Into<S>>(a: &[S], b: &[T]) -> S {
    const LANES: usize = 4;
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sum = [S::ZERO; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sum[k] += a[k] * b[k].into();
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| *a * (*b).into()).reduce(|sum, term| sum + term);
    let rest = rest.unwrap_or(S::ZERO);
    if a.is_empty() {
        return rest;
    }
    (sum[0] + sum[2]) + (sum[1] + sum[3]) + rest
}

/// Only the arms that are not zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sparse<'a> {
    pub(super) joints: usize,
    /// First entry of each muscle, and the end of the last.
    pub(super) start: &'a [usize],
    /// Joint and moment arm of each entry, for all groups.
    pub(super) column: &'a [usize],
    pub(super) value: &'a [f64],
}

impl Rows for Sparse<'_> {
    #[inline(always)]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let entries = self.start[muscle]..self.start[muscle + 1];
        self.column[entries.clone()].iter().copied().zip(self.value[entries].iter().copied())
    }

    #[inline(always)]
    fn joints(self) -> usize {
        self.joints
    }
}

/// The problem of one group of joints and the muscles that cross them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a, R, S> {
    pub(super) rows: R,
    /// Per muscle: limits, reference, inverse of the weight.
    pub(super) lower: &'a [f64],
    pub(super) upper: &'a [f64],
    pub(super) reference: &'a [f64],
    pub(super) compliance: &'a [f64],
    /// Per joint.
    pub(super) torque: &'a [S],
}

impl<'a, R: Rows, S> Block<'a, R, S> {
    /// The same problem with its arms in another layout and its torque in another precision.
    pub(super) fn with<Q, T>(&self, rows: Q, torque: &'a [T]) -> Block<'a, Q, T> {
        let Self { lower, upper, reference, compliance, .. } = *self;
        Block { rows, lower, upper, reference, compliance, torque }
    }

    #[inline(always)]
    pub(super) fn muscles(&self) -> usize {
        self.lower.len()
    }

    #[inline(always)]
    pub(super) fn joints(&self) -> usize {
        self.rows.joints()
    }
}

/// Largest residual relative to the sum of the magnitudes of its terms.
#[inline(always)]
pub(super) fn relative_residual<S: Scalar>(residual: &[S], scale: &[f64]) -> f64 {
    let ratios = residual.iter().zip(scale).map(|(residual, scale)| residual.rounded().abs() / scale);
    // Where all terms are zero, 0 / 0 is no larger than any number.
    ratios.fold(0.0, |largest, ratio| if ratio > largest { ratio } else { largest })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_and_sparse_rows_take_off_the_same_torque_and_add_the_size_of_its_terms() {
        let arms = [0.5, 0.0, -2.0, 0.0, 3.0, 0.25];
        let sparse =
            Sparse { joints: 3, start: &[0, 2, 4], column: &[0, 2, 1, 2], value: &[0.5, -2.0, 3.0, 0.25] };
        let tension = [4.0, -2.0];
        // The second muscle pulls against the first at the last joint.
        let (left, sizes) = ([1.0 - 2.0, 1.0 + 6.0, 1.0 + 8.5], [0.5 + 2.0, 0.5 + 6.0, 0.5 + 8.5]);
        let check = |subtract: &dyn Fn(&mut [f64], &mut [f64])| {
            let (mut residual, mut scale) = ([1.0; 3], [0.5; 3]);
            subtract(&mut residual, &mut scale);
            for j in 0..3 {
                assert!((residual[j] - left[j]).abs() < 1e-15 && (scale[j] - sizes[j]).abs() < 1e-15, "{j}");
            }
        };
        check(&|residual, scale| sparse.subtract_torque(&tension, residual, scale));
        check(&|residual, scale| {
            Dense::<0> { joints: 3, arms: &arms }.subtract_torque(&tension, residual, scale);
        });
        check(&|residual, scale| {
            Dense::<3> { joints: 3, arms: &arms }.subtract_torque(&tension, residual, scale);
        });
    }
}
