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

/// Quantile of Student's t from that of the normal distribution, 1 (Cornish and Fisher).
pub(crate) fn student(z: f64, freedom: usize) -> f64 {
    let n = freedom as f64;
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
    ];
    z + terms[0] / n + terms[1] / (n * n) + terms[2] / n.powi(3)
}

#[cfg(test)]
mod tests {
    use super::student;

    #[test]
    fn the_quantile_of_student_is_that_of_tables() {
        for (freedom, t) in [(6, 5.959), (10, 4.587), (30, 3.646), (1000, 3.300)] {
            assert!((student(3.2905, freedom) - t).abs() < 0.02 * t, "{freedom}");
        }
        assert!((student(1.96, 4) - 2.776).abs() < 0.02);
    }
}
