//! An estimator along conditioned sequences, as at run time.

use crate::fit::run::Run;
use sinew::predictor::{Estimate, Estimator, EstimatorState};

/// Estimates along one sequence, from reset states.
#[must_use]
pub(crate) fn estimate_sequence(estimator: &Estimator, run: &Run) -> Vec<Estimate> {
    let mut state = EstimatorState::new(estimator);
    (0..run.len()).map(|i| state.step(estimator, run.dt_s[i], run.row(i))).collect()
}

/// Root mean square error of an estimator on runs; NaN where no sample counts.
pub(crate) fn rmse(estimator: &Estimator, runs: &[&Run]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        for ((output, far), weight) in estimate_sequence(estimator, run).iter().zip(&run.far).zip(&run.weight)
        {
            sum += weight * (output.mean - far) * (output.mean - far);
            count += weight;
        }
    }
    (sum / count).sqrt()
}
