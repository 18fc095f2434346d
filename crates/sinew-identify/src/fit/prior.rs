//! Gaussian prior on the parameters of a fit, and the re-estimation of its strength by the evidence.
//!
//! ```text
//! C(theta) = beta r^T W r + sum_g alpha_g |theta_g - m_g|^2
//! gamma_g = p_g - alpha_g tr_g(H^-1),   H = beta J^T W J + diag(alpha)
//! alpha_g <- sqrt(alpha_g gamma_g / |theta_g - m_g|^2),   beta <- (N - sum_g gamma_g) / (r^T W r)
//! ```
//!
//! `N` counts independent samples, `gamma_g` the parameters of a group that the data determine.
//!
//! # Departs
//! `alpha_g` is the geometric mean of MacKay's fixed point and its old value: the plain fixed point
//! oscillates while the fit is far from its minimum.
//!
//! # Source
//! `mackay1992`.

use super::linear_algebra::{Cholesky, Matrix};
use super::linearisation::Linearisation;
use std::ops::Range;

/// Precisions of residuals and parameters.
#[derive(Debug, Clone)]
pub(crate) struct Prior {
    /// `beta`, precision of a residual.
    pub precision: f64,
    /// Groups of parameters with one precision each; parameters outside all groups are free.
    pub groups: Vec<Group>,
    /// `m`, what the parameters are drawn to: `[p]`.
    pub mean: Vec<f64>,
    /// Re-estimates the precisions during the fit, where given.
    pub evidence: Option<Evidence>,
}

/// Parameters that share one precision.
#[derive(Debug, Clone)]
pub(crate) struct Group {
    /// Their indices.
    pub range: Range<usize>,
    /// `alpha_g`.
    pub alpha: f64,
}

/// When and on how many samples precisions are re-estimated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evidence {
    /// `N`, independent samples.
    pub samples: f64,
    /// Accepted steps so far.
    pub steps: usize,
}

impl Evidence {
    /// The first steps lead from random weights: what they leave over is not yet noise.
    const FIRST: usize = 3;
    /// Up to here precisions change much and are estimated after every step, then after every second: the
    /// inverse costs as much as a step.
    const EVERY_STEP_UNTIL: usize = 12;
    /// Largest fraction of the samples that may count as spent on parameters.
    const MAX_DETERMINED: f64 = 0.8;

    fn is_due(&self) -> bool {
        self.steps >= Self::FIRST && (self.steps < Self::EVERY_STEP_UNTIL || self.steps.is_multiple_of(2))
    }
}

impl Prior {
    /// No prior on `p` parameters: plain least squares.
    pub(crate) fn none(p: usize) -> Self {
        Self { precision: 1.0, groups: Vec::new(), mean: vec![0.0; p], evidence: None }
    }

    /// The same precision `alpha` for all `p` parameters, drawn to zero.
    pub(crate) fn ridge(p: usize, alpha: f64) -> Self {
        Self { groups: vec![Group { range: 0..p, alpha }], ..Self::none(p) }
    }

    /// `C` at `theta`, given `r^T W r`.
    pub(crate) fn cost(&self, squares: f64, theta: &[f64]) -> f64 {
        let group = |group: &Group| group.alpha * self.squared_distance(group, theta);
        self.precision * squares + self.groups.iter().map(group).sum::<f64>()
    }

    /// Half the gradient of `C`: `[p]`.
    pub(crate) fn gradient(&self, at: &Linearisation, theta: &[f64]) -> Vec<f64> {
        let mut gradient: Vec<f64> = at.gradient.iter().map(|g| self.precision * g).collect();
        for Group { range, alpha } in &self.groups {
            for i in range.clone() {
                gradient[i] += alpha * (theta[i] - self.mean[i]);
            }
        }
        gradient
    }

    /// `H`, the lower triangle of half the Gauss-Newton matrix of `C`: `[p x p]`.
    pub(crate) fn matrix(&self, at: &Linearisation) -> Matrix {
        let p = at.gradient.len();
        let mut matrix =
            Matrix::from_fn(
                p,
                |row, column| {
                    if row < column { 0.0 } else { self.precision * at.normal[(row, column)] }
                },
            );
        for Group { range, alpha } in &self.groups {
            for i in range.clone() {
                matrix[(i, i)] += alpha;
            }
        }
        matrix
    }

    /// Re-estimates the precisions after an accepted step, where there is evidence and it is due.
    pub(crate) fn update(&mut self, at: &Linearisation, theta: &[f64]) {
        let Some(evidence) = &mut self.evidence else { return };
        evidence.steps += 1;
        if !evidence.is_due() {
            return;
        }
        let samples = evidence.samples;
        let Some(factor) = Cholesky::new(self.matrix(at)) else { return };
        let inverse = factor.inverse_diagonal();
        let mut determined = 0.0;
        for k in 0..self.groups.len() {
            let distance = self.squared_distance(&self.groups[k], theta);
            let Group { range, alpha } = &mut self.groups[k];
            let trace: f64 = inverse[range.clone()].iter().sum();
            let gamma = (range.len() as f64 - *alpha * trace).max(0.0);
            determined += gamma;
            *alpha = (*alpha * gamma / distance.max(1e-12)).sqrt().clamp(1e-4, 1e5);
        }
        let determined = determined.min(Evidence::MAX_DETERMINED * samples);
        self.precision = ((samples - determined) / at.squares.max(1e-12)).clamp(1e-6, 1e8);
    }

    fn squared_distance(&self, group: &Group, theta: &[f64]) -> f64 {
        let pairs = theta[group.range.clone()].iter().zip(&self.mean[group.range.clone()]);
        pairs.map(|(t, m)| (t - m) * (t - m)).sum()
    }
}
