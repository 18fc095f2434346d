//! One group of joints and the muscles that cross them: what the solvers work on.

use super::rows::Rows;

/// The problem of one group.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a, R> {
    /// Moment arms, one row per muscle.
    pub(super) rows: R,
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
#[repr(u8)]
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
    #[inline(always)]
    pub(super) fn of(wanted: f64, lower: f64, upper: f64) -> Self {
        // Without a branch: which muscle meets a limit is hard to foretell.
        let above = u8::from(wanted > lower);
        match above + (above & u8::from(wanted >= upper)) {
            0 => Self::Lower,
            1 => Self::Free,
            _ => Self::Upper,
        }
    }

    /// The tension it then has: the limit's own bits where one holds.
    #[inline(always)]
    pub(super) fn clip(wanted: f64, lower: f64, upper: f64) -> f64 {
        let tension = if wanted > lower { wanted } else { lower };
        if tension < upper { tension } else { upper }
    }
}

impl<'a, R: Rows> Block<'a, R> {
    /// The same with its arms kept in another way.
    #[inline(always)]
    pub(super) fn with<Other>(&self, rows: Other) -> Block<'a, Other> {
        let Self { lower, upper, reference, compliance, torque, .. } = *self;
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

    /// `residual = tau - R^T F`.
    #[inline(always)]
    pub(super) fn residual(&self, tension: &[f64], residual: &mut [f64]) {
        let n = self.joints();
        residual[..n].copy_from_slice(&self.torque[..n]);
        self.rows.pull(&tension[..self.muscles()], residual);
    }

    /// The residual, and in `scale` the sum of the magnitudes of what it is made of.
    #[inline(always)]
    pub(super) fn measure(&self, tension: &[f64], residual: &mut [f64], scale: &mut [f64]) {
        let n = self.joints();
        residual[..n].copy_from_slice(&self.torque[..n]);
        for (scale, torque) in scale[..n].iter_mut().zip(&self.torque[..n]) {
            *scale = torque.abs();
        }
        self.rows.pull_and_weigh(&tension[..self.muscles()], residual, scale);
    }
}
