//! Moment arms muscle by muscle: whole rows of known length, or only the entries that are not zero.

/// The matrix `R` of one group of joints.
pub(super) trait Rows: Copy {
    /// Number of joints.
    fn joints(self) -> usize;

    /// What a muscle feels of one number per joint: a row of `R x`.
    fn dot(self, muscle: usize, x: &[f64]) -> f64;

    /// Takes a muscle's torques from `residual` and adds their magnitudes to `scale`.
    fn pull(self, muscle: usize, tension: f64, residual: &mut [f64], scale: &mut [f64]);

    /// Adds `sum f r^T r` over muscles and their `f` to the upper triangle of `h`.
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]);

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
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        let h = &mut h[..N * N];
        for &(muscle, f) in parts {
            let row = &self.arms[muscle];
            for i in 0..N {
                for j in i..N {
                    h[i * N + j] += f * row[i] * row[j];
                }
            }
        }
    }

    #[inline]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        self.arms[muscle].iter().copied().enumerate()
    }
}

/// Numbers handled at once.
pub(super) const LANES: usize = 4;

/// Many joints, all of whose arms are kept, in whole lanes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide<'a> {
    /// Lanes per row.
    lanes: usize,
    arms: &'a [[f64; LANES]],
}

impl<'a> Wide<'a> {
    /// `arms`: row by row; `joints` is a multiple of [`LANES`].
    pub(super) fn new(joints: usize, arms: &'a [f64]) -> Self {
        Self { lanes: joints / LANES, arms: arms.as_chunks().0 }
    }

    #[inline]
    fn lanes(self, muscle: usize) -> &'a [[f64; LANES]] {
        &self.arms[muscle * self.lanes..][..self.lanes]
    }
}

impl Rows for Wide<'_> {
    #[inline]
    fn joints(self) -> usize {
        self.lanes * LANES
    }

    #[inline]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        let mut sum = [0.0; LANES];
        for (arms, x) in self.lanes(muscle).iter().zip(x.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sum[k] += arms[k] * x[k];
            }
        }
        (sum[0] + sum[2]) + (sum[1] + sum[3])
    }

    #[inline]
    fn pull(self, muscle: usize, tension: f64, residual: &mut [f64], scale: &mut [f64]) {
        let (residual, scale) = (residual.as_chunks_mut::<LANES>().0, scale.as_chunks_mut::<LANES>().0);
        for ((arms, residual), scale) in self.lanes(muscle).iter().zip(residual).zip(scale) {
            for k in 0..LANES {
                let torque = arms[k] * tension;
                residual[k] -= torque;
                scale[k] += torque.abs();
            }
        }
    }

    /// Four muscles at a time: what bounds it is reading and writing `h`.
    #[inline]
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        let (fours, rest) = parts.as_chunks::<4>();
        for four in fours {
            self.stiffen_by(four, h);
        }
        for part in rest {
            self.stiffen_by(&[*part], h);
        }
    }

    #[inline]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        self.lanes(muscle).as_flattened().iter().copied().enumerate()
    }
}

impl Wide<'_> {
    /// Fills the lanes that the upper triangle touches.
    #[inline]
    fn stiffen_by<const M: usize>(self, parts: &[(usize, f64); M], h: &mut [f64]) {
        let rows = parts.map(|(muscle, _)| self.lanes(muscle));
        for (i, h) in h.chunks_exact_mut(self.joints()).enumerate() {
            let from = i / LANES;
            let mut f = [0.0; M];
            for k in 0..M {
                f[k] = parts[k].1 * rows[k][from][i % LANES];
            }
            for (at, h) in h.as_chunks_mut::<LANES>().0.iter_mut().enumerate().skip(from) {
                for k in 0..M {
                    let row = &rows[k][at];
                    for lane in 0..LANES {
                        h[lane] += f[k] * row[lane];
                    }
                }
            }
        }
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
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        for &(muscle, f) in parts {
            let (columns, arms) = self.entries(muscle);
            for (k, (&joint, &arm)) in columns.iter().zip(arms).enumerate() {
                let row = &mut h[joint * self.joints..(joint + 1) * self.joints];
                for (&other, &second) in columns[k..].iter().zip(&arms[k..]) {
                    row[other] += f * arm * second;
                }
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
