//! One group of joints and the muscles that cross them: what the solvers work on.

/// The problem of one group. Sparse rows: one per muscle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    /// First entry of each muscle, and the end of the last.
    pub(super) start: &'a [usize],
    /// Joint of each entry, for all groups.
    pub(super) column: &'a [usize],
    /// Moment arm of each entry, for all groups.
    pub(super) value: &'a [f64],
    /// Limits of each muscle.
    pub(super) lower: &'a [f64],
    pub(super) upper: &'a [f64],
    /// Tension of each muscle where nothing is asked of it.
    pub(super) reference: &'a [f64],
    /// Inverse of each muscle's weight.
    pub(super) compliance: &'a [f64],
    /// Torque wanted at each joint.
    pub(super) torque: &'a [f64],
}

/// Which limit holds a muscle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Its least tension.
    Lower,
    /// None.
    Free,
    /// Its greatest tension.
    Upper,
}

impl Limit {
    /// Which limit holds a muscle that would have the tension `wanted`.
    #[inline]
    pub(super) fn of(wanted: f64, lower: f64, upper: f64) -> Self {
        if wanted <= lower {
            Self::Lower
        } else if wanted >= upper {
            Self::Upper
        } else {
            Self::Free
        }
    }
}

impl Block<'_> {
    pub(super) fn muscles(&self) -> usize {
        self.lower.len()
    }

    pub(super) fn joints(&self) -> usize {
        self.torque.len()
    }

    /// Joints and moment arms of a muscle.
    #[inline]
    pub(super) fn row(&self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let entries = self.start[muscle]..self.start[muscle + 1];
        self.column[entries.clone()].iter().copied().zip(self.value[entries].iter().copied())
    }

    /// What a muscle feels of one number per joint: a row of `R x`.
    #[inline]
    pub(super) fn dot(&self, muscle: usize, x: &[f64]) -> f64 {
        self.row(muscle).map(|(joint, arm)| arm * x[joint]).sum()
    }

    /// `residual = tau - R^T F`; `scale` is the sum of the magnitudes of what it is made of.
    #[inline]
    pub(super) fn residual(&self, tension: &[f64], residual: &mut [f64], scale: &mut [f64]) {
        residual.copy_from_slice(self.torque);
        for (scale, torque) in scale.iter_mut().zip(self.torque) {
            *scale = torque.abs();
        }
        for (muscle, tension) in tension.iter().enumerate() {
            for (joint, arm) in self.row(muscle) {
                let torque = arm * tension;
                residual[joint] -= torque;
                scale[joint] += torque.abs();
            }
        }
    }
}
