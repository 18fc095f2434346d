//! Logs conditioned as at run time: spikes held, sequences cut at gaps, no value missing.

use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::log::{Dataset, GAP_INTERVALS, Sequence};
use sinew::predictor::{Conditioner, InputLimits, SampleKind};

/// A change that exceeds the 99.9 % quantile of the changes by this factor, and a quarter of the range, is a
/// spike.
const SPIKE_FACTOR: f64 = 8.0;

/// A dataset with its conditioned sequences and the limits that conditioned them.
#[derive(Debug, Clone)]
pub(crate) struct ConditionedLogs {
    /// The logs as read.
    pub(crate) data: Dataset,
    /// One conditioned sequence for each sequence of `data`.
    pub(crate) runs: Vec<Run>,
    /// Limits of every input.
    pub(crate) limits: Vec<InputLimits>,
    /// Pause after which states are reset, s.
    pub(crate) gap_s: f64,
}

impl ConditionedLogs {
    /// Conditions a dataset with limits derived from it.
    pub(crate) fn new(data: Dataset) -> Self {
        let (limits, gap_s) = (input_limits(&data), gap_s(&data));
        Self::with_limits(data, limits, gap_s)
    }

    /// Conditions a dataset with given limits.
    pub(crate) fn with_limits(data: Dataset, limits: Vec<InputLimits>, gap_s: f64) -> Self {
        let runs = data.sequences.iter().map(|sequence| condition(sequence, &limits, gap_s)).collect();
        Self { data, runs, limits, gap_s }
    }

    /// Conditioned sequences with at least one sample that counts.
    pub(crate) fn counted(&self) -> Vec<&Run> {
        self.runs.iter().filter(|run| run.weight.iter().any(|w| *w > 0.0)).collect()
    }

    /// Largest median sampling interval of the logs, s.
    pub(crate) fn interval_s(&self) -> f64 {
        self.data.logs.iter().map(|log| log.interval_s).fold(0.0, f64::max)
    }

    /// The logs `k` with `keep[k]`, renumbered; limits and gap stay those of all logs.
    pub(crate) fn retain(mut self, keep: &[bool]) -> Self {
        let mut index = Vec::with_capacity(keep.len());
        let mut next = 0;
        for kept in keep {
            index.push(next);
            next += usize::from(*kept);
        }
        self.data.sequences.retain(|sequence| keep[sequence.log]);
        self.data.sequences.iter_mut().for_each(|sequence| sequence.log = index[sequence.log]);
        self.runs.retain(|run| keep[run.log]);
        self.runs.iter_mut().for_each(|run| run.log = index[run.log]);
        let mut kept = keep.iter();
        self.data.logs.retain(|_| kept.next().copied().unwrap_or(true));
        self
    }
}

/// Limits of every input, from the quantiles of its values and changes.
pub(crate) fn input_limits(data: &Dataset) -> Vec<InputLimits> {
    let width = data.roles.inputs.len();
    (0..width).map(|input| limits_of(data, input, width)).collect()
}

fn limits_of(data: &Dataset, input: usize, width: usize) -> InputLimits {
    let (mut values, mut changes) = (Vec::new(), Vec::new());
    for sequence in &data.sequences {
        let column: Vec<f64> = sequence.inputs.iter().skip(input).step_by(width).copied().collect();
        changes.extend(column.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| change.is_finite()));
        values.extend(column.into_iter().filter(|v| v.is_finite()));
    }
    if values.is_empty() {
        return InputLimits { jump: f64::MAX, low: 0.0, high: 0.0, typical: 0.0 };
    }
    let edge = quantiles(values, &EDGES);
    let usual = if changes.is_empty() { 0.0 } else { quantiles(changes, &[0.999])[0] };
    let jump = (SPIKE_FACTOR * usual).max(0.25 * (edge[3] - edge[1]));
    let jump = if jump > 0.0 { jump } else { f64::MAX };
    let (low, high) = between(&edge);
    InputLimits { jump, low, high, typical: edge[2] }
}

/// Quantiles of an input that its known range is made of, and its median.
const EDGES: [f64; 5] = [0.0, 0.005, 0.5, 0.995, 1.0];

/// Extremes beyond one central range are spikes and do not widen the known range.
fn between(edge: &[f64]) -> (f64, f64) {
    let margin = edge[3] - edge[1];
    (edge[0].max(edge[1] - margin), edge[4].min(edge[3] + margin))
}

/// The known range of an input with these values.
pub(crate) fn range_of(values: Vec<f64>) -> (f64, f64) {
    between(&quantiles(values, &EDGES))
}

/// Pause after which states are reset, s.
pub(crate) fn gap_s(data: &Dataset) -> f64 {
    let slowest = data.logs.iter().map(|log| log.interval_s).fold(0.0, f64::max);
    let longest =
        data.sequences.iter().flat_map(|s| s.time_s.windows(2).map(|w| w[1] - w[0])).fold(0.0, f64::max);
    let gap = (GAP_INTERVALS * slowest).max(1.001 * longest);
    if gap > 0.0 && gap.is_finite() { gap } else { 1.0 }
}

/// One conditioned sequence. Samples whose far side is missing keep the last far value at weight zero.
fn condition(sequence: &Sequence, limits: &[InputLimits], gap_s: f64) -> Run {
    let width = limits.len();
    let mut conditioner = Conditioner::new(width);
    let n = sequence.time_s.len();
    let mut far = sequence.far_clean.iter().copied().find(|y| y.is_finite()).unwrap_or(0.0);
    let mut run = Run {
        log: sequence.log,
        dt_s: Vec::with_capacity(n),
        inputs: Vec::with_capacity(n * width),
        far: Vec::with_capacity(n),
        weight: Vec::with_capacity(n),
        width,
    };
    for row in 0..n {
        let inputs = &sequence.inputs[row * width..][..width];
        let kind = conditioner.update(limits, gap_s, sequence.time_s[row], inputs);
        run.dt_s.push(if kind == SampleKind::Next { conditioner.dt_s() } else { 0.0 });
        run.inputs.extend_from_slice(conditioner.values());
        let fitted = sequence.far_clean[row];
        far = if fitted.is_finite() { fitted } else { far };
        run.far.push(far);
        run.weight.push(f64::from(u8::from(sequence.scored[row] && fitted.is_finite())));
    }
    run
}
