//! Moment arms muscle by muscle, dense or sparse.

use super::scalar::Scalar;

/// The rows of the matrix `R` of one group of joints.
pub(super) trait Rows: Copy {
    /// Joints and arms of a muscle, joints ascending.
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone;

    /// Number of joints.
    fn joints(self) -> usize;

    /// Changes the entry of every joint with the muscle's arm about it.
    #[inline(always)]
    fn change<T>(self, muscle: usize, entries: &mut [T], change: impl Fn(&mut T, f64)) {
        for (joint, arm) in self.row(muscle) {
            change(&mut entries[joint], arm);
        }
    }

    /// `R_i x`.
    #[inline(always)]
    fn dot<S: Scalar>(self, muscle: usize, x: &[S]) -> S {
        self.row(muscle).fold(S::ZERO, |sum, (joint, arm)| sum + x[joint] * S::from(arm))
    }

    /// `h := sum_i f_i R_i^T R_i` in the upper triangle.
    #[inline(always)]
    fn weigh<S: Scalar>(self, f: &[f64], h: &mut [S]) {
        let n = self.joints();
        h.fill(S::ZERO);
        for (muscle, &f) in f.iter().enumerate() {
            if f == 0.0 {
                continue;
            }
            let mut rest = self.row(muscle);
            while let Some((joint, arm)) = rest.clone().next() {
                let f = S::from(f) * S::from(arm);
                for (other, second) in rest.clone() {
                    let entry = &mut h[joint * n + other];
                    *entry = *entry + f * S::from(second);
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
        let n = self.joints();
        &self.arms[muscle * n..][..n]
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

    // Over slices, which the compiler vectorises.
    #[inline(always)]
    fn change<T>(self, muscle: usize, entries: &mut [T], change: impl Fn(&mut T, f64)) {
        for (entry, arm) in entries[..self.joints()].iter_mut().zip(self.arms(muscle)) {
            change(entry, *arm);
        }
    }

    #[inline(always)]
    fn weigh<S: Scalar>(self, f: &[f64], h: &mut [S]) {
        let n = self.joints();
        h.fill(S::ZERO);
        for (muscle, &f) in f.iter().enumerate() {
            if f == 0.0 {
                continue;
            }
            let arms = self.arms(muscle);
            for (joint, row) in h.chunks_exact_mut(n).enumerate() {
                let f = S::from(f) * S::from(arms[joint]);
                for (entry, arm) in row[joint..].iter_mut().zip(&arms[joint..]) {
                    *entry = *entry + f * S::from(*arm);
                }
            }
        }
    }
}

/// Sum of products, several at a time.
#[inline(always)]
pub(super) fn dot<S: Scalar, T: Copy + Into<S>>(a: &[S], b: &[T]) -> S {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sum = [S::ZERO; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|k| sum[k] = sum[k] + a[k] * b[k].into());
    }
    let rest = a_rest.iter().zip(b_rest).fold(S::ZERO, |sum, (a, b)| sum + *a * (*b).into());
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
