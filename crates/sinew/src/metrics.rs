//! Errors of an estimate: eqs. 14 to 16, one sample at a time.

use crate::error::{Error, finite, non_negative};

/// Running comparison of an estimate with the truth: one pass, constant memory, numerically stable.
///
/// ```text
/// MSE  = 1/N sum (yhat - y)^2          RMSE = sqrt(MSE)
/// rho  = 1/(N-1) sum (yhat - mean yhat)(y - mean y) / (sd yhat  sd y)
/// ```
///
/// | symbol | argument     | unit     | domain | meaning                                |
/// |--------|--------------|----------|--------|----------------------------------------|
/// | y      | `truth`      | any      | finite | measured value                          |
/// | yhat   | `estimate`   | as truth | finite | predicted value                         |
/// |        | `half_width` | as truth | >= 0   | half width of the band around `estimate` |
///
/// MSE has the square of the signal's unit. Means and moments are updated by Welford's recursion, so a
/// large offset costs no digits.
///
/// # Example
/// ```
/// use sinew::metrics::Comparison;
/// let mut comparison = Comparison::new();
/// for (truth, estimate) in [(1.0, 1.5), (2.0, 2.5), (3.0, 3.5)] {
///     comparison.push(truth, estimate)?;
/// }
/// assert_eq!(comparison.rmse(), Some(0.5));                // a constant offset is an error
/// assert!((comparison.pearson().unwrap() - 1.0).abs() < 1e-15); // that correlation does not see
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eqs. 14 to 16; recursion: `welford1962`, merging: `chan1983`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    count: u64,
    mean_truth: f64,
    mean_estimate: f64,
    /// Sums of squared deviations from the means, and of their product.
    squares_truth: f64,
    squares_estimate: f64,
    product: f64,
    /// Mean, not sum, of the squared error: the sum would overflow first.
    mean_squared_error: f64,
    least: f64,
    greatest: f64,
    banded: u64,
    covered: u64,
}

impl Default for Comparison {
    fn default() -> Self {
        Self::new()
    }
}

impl Comparison {
    /// A comparison of nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            count: 0,
            mean_truth: 0.0,
            mean_estimate: 0.0,
            squares_truth: 0.0,
            squares_estimate: 0.0,
            product: 0.0,
            mean_squared_error: 0.0,
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            banded: 0,
            covered: 0,
        }
    }

    /// Adds a sample.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where a value is not finite; the sample is then not counted.
    pub fn push(&mut self, truth: f64, estimate: f64) -> Result<(), Error> {
        finite("truth", truth)?;
        finite("estimate", estimate)?;
        self.count += 1;
        let n = self.count as f64;
        let (off_truth, off_estimate) = (truth - self.mean_truth, estimate - self.mean_estimate);
        self.mean_truth += off_truth / n;
        self.mean_estimate += off_estimate / n;
        self.squares_truth += off_truth * (truth - self.mean_truth);
        self.squares_estimate += off_estimate * (estimate - self.mean_estimate);
        self.product += off_truth * (estimate - self.mean_estimate);
        let error = estimate - truth;
        self.mean_squared_error += (error * error - self.mean_squared_error) / n;
        self.least = self.least.min(truth);
        self.greatest = self.greatest.max(truth);
        Ok(())
    }

    /// Adds a sample with a band, which counts for [`Comparison::coverage`] too.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where a value is not finite or the width negative; the sample is then not
    /// counted.
    pub fn push_with_band(&mut self, truth: f64, estimate: f64, half_width: f64) -> Result<(), Error> {
        non_negative("half_width", half_width)?;
        self.push(truth, estimate)?;
        self.banded += 1;
        self.covered += u64::from((estimate - truth).abs() <= half_width);
        Ok(())
    }

    /// Adds all samples of another comparison.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let fraction = m / (n + m);
        let (off_truth, off_estimate) =
            (other.mean_truth - self.mean_truth, other.mean_estimate - self.mean_estimate);
        self.squares_truth += other.squares_truth + off_truth * off_truth * n * fraction;
        self.squares_estimate += other.squares_estimate + off_estimate * off_estimate * n * fraction;
        self.product += other.product + off_truth * off_estimate * n * fraction;
        self.mean_truth += off_truth * fraction;
        self.mean_estimate += off_estimate * fraction;
        self.mean_squared_error += (other.mean_squared_error - self.mean_squared_error) * fraction;
        self.count += other.count;
        self.least = self.least.min(other.least);
        self.greatest = self.greatest.max(other.greatest);
        self.banded += other.banded;
        self.covered += other.covered;
    }

    /// Samples counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean squared error, unit squared: (14). `None` below two samples.
    #[must_use]
    pub fn mse(&self) -> Option<f64> {
        (self.count >= 2).then_some(self.mean_squared_error).filter(|mse| mse.is_finite())
    }

    /// Root mean squared error: (15). `None` below two samples.
    #[must_use]
    pub fn rmse(&self) -> Option<f64> {
        self.mse().map(libm::sqrt)
    }

    /// Pearson correlation in [-1, 1]: (16), sample covariance (`N - 1`, which cancels).
    /// `None` below two samples or where either signal is constant.
    #[must_use]
    #[doc(alias = "correlation")]
    pub fn pearson(&self) -> Option<f64> {
        let scale = libm::sqrt(self.squares_truth) * libm::sqrt(self.squares_estimate);
        (self.count >= 2 && scale > 0.0 && scale.is_finite())
            .then(|| (self.product / scale).clamp(-1.0, 1.0))
            .filter(|rho| rho.is_finite())
    }

    /// Greatest minus least truth. `None` below two samples or for a constant signal.
    #[must_use]
    pub fn range(&self) -> Option<f64> {
        let range = self.greatest - self.least;
        (self.count >= 2 && range > 0.0 && range.is_finite()).then_some(range)
    }

    /// RMSE as % of a range, by default that of the truth. `None` below two samples or without a range.
    #[must_use]
    pub fn percent_of_range(&self, range: Option<f64>) -> Option<f64> {
        let range = range.or_else(|| self.range()).filter(|range| range.is_finite() && *range > 0.0)?;
        self.rmse().map(|rmse| 100.0 * rmse / range)
    }

    /// Fraction of the banded samples within their band, in [0, 1]. `None` below two of them.
    #[must_use]
    pub fn coverage(&self) -> Option<f64> {
        (self.banded >= 2).then(|| self.covered as f64 / self.banded as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn of(pairs: &[(f64, f64)]) -> Comparison {
        let mut comparison = Comparison::new();
        for &(truth, estimate) in pairs {
            comparison.push(truth, estimate).unwrap();
        }
        comparison
    }

    proptest! {
        #[test]
        fn streaming_equals_two_passes_even_far_from_zero(
            pairs in proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 2..60),
            offset in prop_oneof![Just(0.0), Just(1e7), Just(-3e5)], cut in 0..60_usize,
        ) {
            let n = pairs.len() as f64;
            // Offsets round the samples; the reference must see the rounded ones.
            let pairs: Vec<(f64, f64)> = pairs.iter().map(|(y, e)| (y + offset, e + offset)).collect();
            let near: Vec<(f64, f64)> = pairs.iter().map(|(y, e)| (y - offset, e - offset)).collect();
            let mean = |f: &dyn Fn(&(f64, f64)) -> f64| near.iter().map(f).sum::<f64>() / n;
            let (mt, me) = (mean(&|p| p.0), mean(&|p| p.1));
            let mse = mean(&|p| (p.1 - p.0) * (p.1 - p.0));
            let cov = mean(&|p| (p.0 - mt) * (p.1 - me));
            let [vt, ve] = [mean(&|p| (p.0 - mt) * (p.0 - mt)), mean(&|p| (p.1 - me) * (p.1 - me))];
            let rho = cov / libm::sqrt(vt * ve);
            // Rounding of the means, over what they are taken from.
            let rounding = 4.0 * f64::EPSILON * offset.abs() / libm::sqrt(vt.min(ve));
            let whole = of(&pairs);
            let (head, tail) = pairs.split_at(cut.min(pairs.len()));
            let mut merged = of(head);
            merged.merge(&of(tail));
            for comparison in [whole, merged] {
                prop_assert!((comparison.mse().unwrap() - mse).abs() < 1e-9);
                prop_assert_eq!(comparison.count(), pairs.len() as u64);
                if let Some(pearson) = comparison.pearson() {
                    prop_assert!((pearson - rho).abs() < 1e-6 + rounding, "{pearson} {rho}");
                }
            }
        }
    }

    #[test]
    fn too_few_samples_and_constant_signals_have_no_answer() {
        assert_eq!(Comparison::new().rmse(), None);
        assert_eq!(of(&[(1.0, 1.0)]).mse(), None);
        let constant = of(&[(2.0, 1.0), (2.0, 3.0), (2.0, 2.0)]);
        assert_eq!(
            (constant.pearson(), constant.range(), constant.percent_of_range(None)),
            (None, None, None)
        );
        assert!(constant.rmse().is_some() && constant.percent_of_range(Some(4.0)).is_some());
        assert_eq!(constant.coverage(), None);
    }

    #[test]
    fn coverage_counts_the_banded_samples_only() {
        let mut comparison = of(&[(0.0, 9.0)]);
        for truth in [0.0, 0.5, 1.0, 2.0] {
            comparison.push_with_band(truth, 0.0, 1.0).unwrap();
        }
        assert_eq!(comparison.coverage(), Some(0.75));
        assert_eq!(comparison.count(), 5);
    }

    #[test]
    fn what_is_not_finite_is_refused_and_not_counted() {
        let mut comparison = of(&[(0.0, 1.0), (1.0, 2.0)]);
        let before = comparison;
        assert!(comparison.push(f64::NAN, 0.0).is_err());
        assert!(comparison.push(0.0, f64::INFINITY).is_err());
        assert!(comparison.push_with_band(0.0, 0.0, -1.0).is_err());
        assert_eq!(comparison, before);
    }
}
