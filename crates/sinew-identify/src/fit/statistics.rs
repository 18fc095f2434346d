//! Order statistics and moments of samples.

/// Values at the fractions `at` of the sorted `values`; zeros where there are none.
#[must_use]
pub(crate) fn quantiles(mut values: Vec<f64>, at: &[f64]) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    at.iter().map(|q| values.get((q * last).round() as usize).copied().unwrap_or(0.0)).collect()
}

/// Mean and standard deviation (divisor `n`); zeros where there are no values.
pub(crate) fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt())
}
