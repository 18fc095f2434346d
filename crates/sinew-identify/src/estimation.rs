//! An estimator along conditioned sequences, as at run time.

use crate::fit::run::Run;
use sinew::predictor::{Estimate, Estimator, Memory};

/// Estimates along one sequence, from reset states.
#[must_use]
pub(crate) fn estimate_sequence(estimator: &Estimator, run: &Run) -> Vec<Estimate> {
    let mut memory = Memory::new(&estimator.law);
    let mut scratch = vec![0.0; estimator.law.features.len()];
    (0..run.len())
        .map(|i| {
            memory.step(&estimator.law, run.dt_s[i], run.row(i));
            estimator.estimate(&memory, &mut scratch)
        })
        .collect()
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
