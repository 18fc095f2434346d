//! Moment arms muscle by muscle: whole rows of known length, or only the entries that are not zero.

/// The matrix `R` of one group of joints.
pub(super) trait Rows: Copy {
    /// Number of joints.
    fn joints(self) -> usize;

    /// What a muscle feels of one number per joint: a row of `R x`.
    fn dot(self, muscle: usize, x: &[f64]) -> f64;

    /// Takes a muscle's torques from `residual` and adds their magnitudes to `scale`.
    fn pull(self, muscle: usize, tension: f64, residual: &mut [f64], scale: &mut [f64]);

    /// Adds `f r^T r` to the upper triangle of `h`.
    fn stiffen(self, muscle: usize, f: f64, h: &mut [f64]);

    /// Joints and arms of a muscle.
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)>;
}

/// Few joints, all of whose arms are kept: the compiler unrolls what is done with them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dense<'a, const N: usize> {
    arms: &'a [[f64; N]],
}

impl<'a, const N: usize> Dense<'a, N> {
    /// `arms`: row by row.
    pub(super) fn new(arms: &'a [f64]) -> Self {
        Self { arms: arms.as_chunks().0 }
    }
}

impl<const N: usize> Rows for Dense<'_, N> {
    #[inline]
    fn joints(self) -> usize {
        N
    }

    #[inline]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        self.arms[muscle].iter().zip(&x[..N]).map(|(arm, x)| arm * x).sum()
    }

    #[inline]
    fn pull(self, muscle: usize, tension: f64, residual: &mut [f64], scale: &mut [f64]) {
        let (residual, scale) = (&mut residual[..N], &mut scale[..N]);
        for ((arm, residual), scale) in self.arms[muscle].iter().zip(residual).zip(scale) {
            let torque = arm * tension;
            *residual -= torque;
            *scale += torque.abs();
        }
    }

    #[inline]
    fn stiffen(self, muscle: usize, f: f64, h: &mut [f64]) {
        let (row, h) = (&self.arms[muscle], &mut h[..N * N]);
        for i in 0..N {
            for j in i..N {
                h[i * N + j] += f * row[i] * row[j];
            }
        }
    }

    #[inline]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        self.arms[muscle].iter().copied().enumerate()
    }
}

/// Many joints, few of which each muscle crosses.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sparse<'a> {
    pub(super) joints: usize,
    /// First entry of each muscle, and the end of the last.
    pub(super) start: &'a [usize],
    /// Joint and moment arm of each entry, for all groups.
    pub(super) column: &'a [usize],
    pub(super) value: &'a [f64],
}

impl Sparse<'_> {
    #[inline]
    fn entries(&self, muscle: usize) -> (&[usize], &[f64]) {
        let entries = self.start[muscle]..self.start[muscle + 1];
        (&self.column[entries.clone()], &self.value[entries])
    }
}

impl Rows for Sparse<'_> {
    #[inline]
    fn joints(self) -> usize {
        self.joints
    }

    #[inline]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        self.row(muscle).map(|(joint, arm)| arm * x[joint]).sum()
    }

    #[inline]
    fn pull(self, muscle: usize, tension: f64, residual: &mut [f64], scale: &mut [f64]) {
        for (joint, arm) in self.row(muscle) {
            let torque = arm * tension;
            residual[joint] -= torque;
            scale[joint] += torque.abs();
        }
    }

    #[inline]
    fn stiffen(self, muscle: usize, f: f64, h: &mut [f64]) {
        let (columns, arms) = self.entries(muscle);
        for (k, (&joint, &arm)) in columns.iter().zip(arms).enumerate() {
            let row = &mut h[joint * self.joints..(joint + 1) * self.joints];
            for (&other, &second) in columns[k..].iter().zip(&arms[k..]) {
                row[other] += f * arm * second;
            }
        }
    }

    #[inline]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.start[muscle]..self.start[muscle + 1];
        let (columns, arms) = (&self.column[entries.clone()], &self.value[entries]);
        columns.iter().zip(arms).map(|(joint, arm)| (*joint, *arm))
    }
}
