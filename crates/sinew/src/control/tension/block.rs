//! One group's problem, its muscles during the search, and the residual of their tensions.

use super::problem::Limit;
use super::rows::Rows;
use super::scalar::Scalar;
use alloc::vec::Vec;

/// One muscle of a group.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Muscle {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) reference: f64,
    /// Inverse of the weight.
    pub(super) compliance: f64,
}

/// A muscle at some multipliers and along the step from them.
#[derive(Debug, Clone, Copy)]
pub(super) struct State<S> {
    /// `F_ref + W^-1 R lambda`, and `F`, which is that within the limits.
    pub(super) unclipped: S,
    pub(super) tension: S,
    pub(super) limit: Limit,
    /// `R_i d` and `R_i d / w_i`, where `d` is the step.
    pub(super) pull: S,
    pub(super) rate: S,
}

impl<S: Scalar> State<S> {
    pub(super) const ZERO: Self =
        Self { unclipped: S::ZERO, tension: S::ZERO, limit: Limit::Free, pull: S::ZERO, rate: S::ZERO };

    /// Sets the tension to the nearest within the limits; the limit's own bits where one holds.
    #[inline(always)]
    pub(super) fn clip(&mut self, muscle: &Muscle) {
        let (lower, upper) = (S::from(muscle.lower), S::from(muscle.upper));
        let tension = if self.unclipped > lower { self.unclipped } else { lower };
        self.tension = if tension < upper { tension } else { upper };
    }
}

/// The problem of one group of joints and the muscles that cross them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a, R, S> {
    pub(super) rows: R,
    pub(super) muscles: &'a [Muscle],
    /// Per joint.
    pub(super) torque: &'a [S],
}

/// Residual for some tensions.
#[derive(Debug, Clone)]
pub(super) struct Residual<S> {
    /// `tau - R^T F`.
    pub(super) torque: Vec<S>,
    /// `|tau_j| + sum_i |R_ij F_i|`.
    pub(super) scale: Vec<f64>,
}

impl<S: Scalar> Residual<S> {
    pub(super) fn new(joints: usize) -> Self {
        Self { torque: alloc::vec![S::ZERO; joints], scale: alloc::vec![0.0; joints] }
    }

    /// Sets it to that of these tensions, one per muscle.
    #[inline(always)]
    pub(super) fn measure<R: Rows>(&mut self, block: &Block<R, S>, tensions: impl Iterator<Item = S>) {
        const FEW: usize = 3;
        let n = block.rows.joints();
        let mut few = ([S::ZERO; FEW], [0.0; FEW]);
        // Few sums stay in registers where their number is known to the compiler.
        let (torque, scale) = match n <= FEW {
            true => (&mut few.0[..n], &mut few.1[..n]),
            false => (&mut self.torque[..n], &mut self.scale[..n]),
        };
        torque.copy_from_slice(&block.torque[..n]);
        scale.iter_mut().zip(&*torque).for_each(|(scale, torque)| *scale = torque.rounded().abs());
        for (muscle, tension) in tensions.enumerate() {
            block.rows.change(muscle, torque, |torque, arm| *torque = *torque - tension * S::from(arm));
            block.rows.change(muscle, scale, |scale, arm| {
                *scale += (tension * S::from(arm)).rounded().abs();
            });
        }
        if n <= FEW {
            self.torque[..n].copy_from_slice(&few.0[..n]);
            self.scale[..n].copy_from_slice(&few.1[..n]);
        }
    }
}

/// Largest entry relative to its scale.
#[inline(always)]
pub(super) fn relative<S: Scalar>(entries: &[S], scale: &[f64]) -> f64 {
    let ratios = entries.iter().zip(scale).map(|(entry, scale)| entry.rounded().abs() / scale);
    // Where all terms are zero, 0 / 0 is no larger than any number.
    ratios.fold(0.0, |largest, ratio| if ratio > largest { ratio } else { largest })
}

#[cfg(test)]
mod tests {
    use super::super::rows::{Dense, Rows, Sparse};
    use super::{Block, Residual};

    #[test]
    fn dense_and_sparse_rows_leave_the_same_residual_and_add_the_size_of_its_terms() {
        let arms = [0.5, 0.0, -2.0, 0.0, 3.0, 0.25];
        let sparse =
            Sparse { joints: 3, start: &[0, 2, 4], column: &[0, 2, 1, 2], value: &[0.5, -2.0, 3.0, 0.25] };
        // The second muscle pulls against the first at the last joint.
        let (left, sizes) = ([1.0 - 2.0, 1.0 + 6.0, 1.0 + 8.5], [1.0 + 2.0, 1.0 + 6.0, 1.0 + 8.5]);
        fn check(rows: impl Rows, left: [f64; 3], sizes: [f64; 3]) {
            let mut residual = Residual::new(3);
            residual.measure(&Block { rows, muscles: &[], torque: &[1.0; 3] }, [4.0, -2.0].into_iter());
            for j in 0..3 {
                let errors = [residual.torque[j] - left[j], residual.scale[j] - sizes[j]];
                assert!(errors.iter().all(|error| error.abs() < 1e-15), "{j}: {errors:?}");
            }
        }
        check(sparse, left, sizes);
        check(Dense::<0> { joints: 3, arms: &arms }, left, sizes);
        check(Dense::<3> { joints: 3, arms: &arms }, left, sizes);
    }

    #[test]
    fn more_joints_than_few_have_their_residual_too() {
        let mut residual = Residual::new(5);
        let rows = Dense::<0> { joints: 5, arms: &[1.0, -2.0, 3.0, -4.0, 5.0] };
        residual.measure(&Block { rows, muscles: &[], torque: &[1.0; 5] }, [2.0].into_iter());
        assert_eq!(residual.torque, [-1.0, 5.0, -5.0, 9.0, -9.0]);
        assert_eq!(residual.scale, [3.0, 5.0, 7.0, 9.0, 11.0]);
    }
}
