//! Standardisation of the features of networks and regressions.

use super::statistics::{mean_and_deviation, quantiles};

/// Clip box, mean and scale of every feature: `[features]` each.
pub(super) struct Standardisation {
    pub(super) low: Vec<f64>,
    pub(super) high: Vec<f64>,
    pub(super) mean: Vec<f64>,
    pub(super) scale: Vec<f64>,
}

impl Standardisation {
    /// Of `features: [n x width]`, row-major.
    pub(super) fn new(features: &[f64], width: usize) -> Self {
        let mut standard = Self { low: vec![], high: vec![], mean: vec![], scale: vec![] };
        for i in 0..width {
            let mut column: Vec<f64> = features.iter().skip(i).step_by(width).copied().collect();
            let edge = quantiles(column.clone(), &[0.0005, 0.9995]);
            column.iter_mut().for_each(|v| *v = v.max(edge[0]).min(edge[1]));
            let (mean, spread) = mean_and_deviation(&column);
            standard.low.push(edge[0]);
            standard.high.push(edge[1]);
            standard.mean.push(mean);
            // A constant feature carries no information and becomes 0.
            standard.scale.push(if spread > 1e-9 { spread } else { 1.0 });
        }
        standard
    }

    /// Standardised features, in the same layout.
    pub(super) fn apply(&self, features: &[f64]) -> Vec<f64> {
        let width = self.mean.len();
        let one = |(k, x): (usize, &f64)| {
            let i = k % width;
            (x.max(self.low[i]).min(self.high[i]) - self.mean[i]) / self.scale[i]
        };
        features.iter().enumerate().map(one).collect()
    }
}
