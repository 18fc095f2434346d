//! Sequences as the predictor will see them: spikes held, gaps cut, nothing missing.

use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::log::{Dataset, GAP_INTERVALS, Sequence};
use sinew::predictor::{Conditioner, InputLimits, SampleKind};

/// A change that exceeds the usual ones by this factor (99.9 % quantile) and a quarter of the range is a spike.
const SPIKE_FACTOR: f64 = 8.0;

/// What the conditioner may believe of every input, learned from the logs.
pub(crate) fn guards(data: &Dataset) -> Vec<InputLimits> {
    let width = data.roles.inputs.len();
    (0..width)
        .map(|i| {
            let column =
                |s: &Sequence| -> Vec<f64> { s.inputs.iter().skip(i).step_by(width).copied().collect() };
            let mut values = Vec::new();
            let mut changes = Vec::new();
            for sequence in &data.sequences {
                let column = column(sequence);
                changes.extend(
                    column.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| change.is_finite()),
                );
                values.extend(column.into_iter().filter(|v| v.is_finite()));
            }
            if values.is_empty() {
                return InputLimits { jump: f64::MAX, low: 0.0, high: 0.0, typical: 0.0 };
            }
            let edge = quantiles(values, &[0.0, 0.005, 0.5, 0.995, 1.0]);
            let usual = if changes.is_empty() { 0.0 } else { quantiles(changes, &[0.999])[0] };
            let jump = (SPIKE_FACTOR * usual).max(0.25 * (edge[3] - edge[1]));
            let jump = if jump > 0.0 { jump } else { f64::MAX };
            // Spikes must not widen the range that counts as known.
            let margin = edge[3] - edge[1];
            InputLimits {
                jump,
                low: edge[0].max(edge[1] - margin),
                high: edge[4].min(edge[3] + margin),
                typical: edge[2],
            }
        })
        .collect()
}

/// Pause after which states are forgotten, s.
pub(crate) fn gap_s(data: &Dataset) -> f64 {
    let slowest = data.logs.iter().map(|log| log.interval_s).fold(0.0, f64::max);
    let longest =
        data.sequences.iter().flat_map(|s| s.time_s.windows(2).map(|w| w[1] - w[0])).fold(0.0, f64::max);
    let gap = (GAP_INTERVALS * slowest).max(1.001 * longest);
    if gap > 0.0 && gap.is_finite() { gap } else { 1.0 }
}

/// Every sequence, conditioned. Samples whose far side is missing keep the last far value at weight zero.
pub(crate) fn condition(data: &Dataset, guards: &[InputLimits], gap_s: f64) -> Vec<Run> {
    data.sequences.iter().map(|sequence| condition_sequence(sequence, guards, gap_s)).collect()
}

fn condition_sequence(sequence: &Sequence, guards: &[InputLimits], gap_s: f64) -> Run {
    let width = guards.len();
    let mut conditioner = Conditioner::new(width);
    let n = sequence.time_s.len();
    let mut far = sequence.far_clean.iter().copied().find(|y| y.is_finite()).unwrap_or(0.0);
    let mut run = Run {
        log: sequence.log,
        group: Vec::new(),
        dt_s: Vec::with_capacity(n),
        inputs: Vec::with_capacity(n * width),
        far: Vec::with_capacity(n),
        weight: Vec::with_capacity(n),
        width,
    };
    for row in 0..n {
        let inputs = &sequence.inputs[row * width..][..width];
        let step = conditioner.update(guards, gap_s, sequence.time_s[row], inputs);
        run.dt_s.push(if step == SampleKind::Next { conditioner.dt_s() } else { 0.0 });
        run.inputs.extend_from_slice(conditioner.values());
        let fitted = sequence.far_clean[row];
        far = if fitted.is_finite() { fitted } else { far };
        run.far.push(far);
        run.weight.push(f64::from(u8::from(sequence.scored[row] && fitted.is_finite())));
    }
    run
}
