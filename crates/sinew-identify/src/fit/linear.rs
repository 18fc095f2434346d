//! Linear regression on the features of a recipe, as a law of its own or in the form of an ensemble without
//! hidden nodes.

use super::linear_algebra::{Cholesky, Matrix};
use super::standardisation::Standardisation;
use sinew::predictor::{Ensemble, LinearLaw, MAX_MAGNITUDE};

/// Ridge relative to the variance of a standardised feature: lags of one signal are nearly collinear.
pub(crate) const RIDGE: f64 = 1e-4;

/// Least squares of `targets: [n]` on `features: [n x width]`, row-major; without features their mean.
///
/// ```text
/// y = b + a . z,      (Z^T Z / n + r I) a = Z^T (y - b) / n,      b = mean y
/// ```
///
/// | symbol | meaning                     |
/// |--------|-----------------------------|
/// | z      | standardised features        |
/// | r      | ridge, 1e-4                  |
pub(super) fn regress(features: &[f64], targets: &[f64], width: usize) -> Option<Ensemble> {
    let standard = Standardisation::new(features, width);
    let (weights, mean) = solve(&standard.apply(features), targets, width, RIDGE)?;
    Some(Ensemble {
        hidden_weights: Vec::new(),
        hidden_bias: Vec::new(),
        output_weights: Vec::new(),
        skip: weights.iter().map(|w| [*w as f32; sinew::predictor::MEMBERS]).collect(),
        bias: [mean as f32; sinew::predictor::MEMBERS],
        clip_low: standard.low,
        clip_high: standard.high,
        inverse_scale: standard.scale.iter().map(|s| 1.0 / s).collect(),
        mean: standard.mean,
    })
}

/// The same as a law in the units of the features, without a box; `ridge` as `r`.
pub(super) fn linear_law(features: &[f64], targets: &[f64], width: usize, ridge: f64) -> Option<LinearLaw> {
    let mut standard = Standardisation::new(features, width);
    standard.low.fill(-MAX_MAGNITUDE);
    standard.high.fill(MAX_MAGNITUDE);
    let (weights, mean) = solve(&standard.apply(features), targets, width, ridge)?;
    let weights: Vec<f64> = weights.iter().zip(&standard.scale).map(|(w, s)| w / s).collect();
    let offset = mean - weights.iter().zip(&standard.mean).map(|(w, m)| w * m).sum::<f64>();
    Some(LinearLaw { offset, weights })
}

/// `a` and `b` for standardised features.
fn solve(inputs: &[f64], targets: &[f64], width: usize, ridge: f64) -> Option<(Vec<f64>, f64)> {
    let n = targets.len();
    if n == 0 {
        return None;
    }
    let mean = targets.iter().sum::<f64>() / n as f64;
    let row = |i: usize| &inputs[i * width..][..width];
    let mut normal = Matrix::from_fn(width, |i, j| if i == j { ridge } else { 0.0 });
    let mut right = vec![0.0; width];
    for (k, target) in targets.iter().enumerate() {
        let z = row(k);
        for i in 0..width {
            right[i] += z[i] * (target - mean) / n as f64;
            for j in 0..=i {
                normal[(i, j)] += z[i] * z[j] / n as f64;
            }
        }
    }
    let weights = if width > 0 { Cholesky::new(normal)?.solve(&right)? } else { Vec::new() };
    Some((weights, mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_relation_comes_back_and_without_features_the_mean() {
        let features: Vec<f64> = (0..400).flat_map(|i| [f64::from(i % 20), f64::from(i / 20)]).collect();
        let targets: Vec<f64> = features.chunks_exact(2).map(|x| 3.0 + 2.0 * x[0] - 0.5 * x[1]).collect();
        let model = regress(&features, &targets, 2).unwrap();
        for (x, y) in features.chunks_exact(2).zip(&targets) {
            let output = model.evaluate(x, &mut [0.0; 2]);
            assert!((output.median - y).abs() < 5e-3 && output.variance < 1e-6, "{output:?} {y}");
        }
        let law = linear_law(&features, &targets, 2, RIDGE).unwrap();
        // Also far beyond the training data.
        assert!((law.value(&[100.0, -50.0]) - 228.0).abs() < 0.1, "{law:?}");
        let constant = regress(&[], &targets, 0).unwrap();
        let mean = targets.iter().sum::<f64>() / 400.0;
        assert!((constant.evaluate(&[], &mut []).median - mean).abs() < 1e-5);
        assert!(regress(&[], &[], 0).is_none());
    }
}
