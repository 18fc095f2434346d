//! An estimator along conditioned sequences, as at run time.

use crate::fit::run::Run;
use sinew::predictor::{Axis, Estimate, Estimator, EstimatorState, MEMBERS};

/// Estimates along one sequence, from reset states.
#[must_use]
pub(crate) fn estimate_sequence(estimator: &Estimator, run: &Run) -> Vec<Estimate> {
    let mut state = EstimatorState::new(estimator);
    (0..run.len()).map(|i| state.step(estimator, run.dt_s[i], run.row(i))).collect()
}

/// Numbers that were fitted, those of its members included.
pub(crate) fn size(estimator: &Estimator) -> usize {
    let law = &estimator.law;
    let cell = law.cell.as_ref().map_or(0, |c| c.low.len() + c.high.len() + c.kappa.len());
    let ensemble = estimator.ensemble.as_ref().map_or(0, |e| {
        let lanes = e.hidden_weights.len() + e.hidden_bias.len() + e.output_weights.len() + e.skip.len() + 1;
        // Without nodes all networks are one regression.
        if e.hidden_bias.is_empty() { lanes } else { lanes * MEMBERS }
    });
    let perceptron = estimator.perceptron.as_ref().map_or(0, |p| p.hidden() * (p.inputs() + 2) + 1);
    let axis = law.axis.as_ref().map_or(0, |axis| match axis {
        Axis::Force(law) => 4 + 2 * law.slips.len() + law.gains.len(),
        Axis::Motion(_) => 5,
    });
    let cable = law.cable.as_ref().map_or(0, |_| CABLE_NUMBERS);
    let linear = estimator.linear.as_ref().map_or(0, |linear| linear.weights.len() + 1);
    let members: usize = estimator.members.iter().map(|member| size(&member.estimator)).sum();
    cell + axis + cable + ensemble + perceptron + linear + members
}

/// Friction angle, drag, pretension, two compliances.
const CABLE_NUMBERS: usize = 5;

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
