//! Whether the far end rises or falls with the near side.

use crate::predictor::{Model, ModelFileError, Predictor, Sample};

/// Part of the longest interval between samples over which the near side moves in the trial.
const OF_GAP: f64 = 0.05;

/// The change of the far end, far unit, as one input goes from the lower to the upper end of its range in
/// training, from a start at typical values; zero where it does not depend on it. For the motor of a cable's
/// observer, the sign of its column.
///
/// # Errors
/// As [`Model::validate`].
pub(super) fn direction(model: &Model, near: usize) -> Result<f64, ModelFileError> {
    if let Some(cable) = model.estimator.law.cable.as_ref().filter(|cable| cable.columns.motor == near) {
        return Ok(cable.columns.motor_scale * cable.model.far_gain);
    }
    let mut unguarded = model.clone();
    for guard in &mut unguarded.guards {
        guard.jump = f64::MAX;
    }
    let typical = || model.guards.iter().map(|guard| guard.typical);
    let mut begun = Predictor::new(unguarded)?;
    let mut row: alloc::vec::Vec<f64> = typical().collect();
    begun.step(&Sample { time_s: 0.0, inputs: &row });
    let mut at = |value: f64| {
        row[near] = value;
        begun.clone().step(&Sample { time_s: OF_GAP * model.gap_s, inputs: &row }).mean
    };
    Ok(at(model.guards[near].high) - at(model.guards[near].low))
}
