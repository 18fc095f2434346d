//! Inputs that repeat the far side, and logs whose far side has the opposite sign.

use super::types::{Dataset, Role, Sequence};

/// Fraction of the far side's variance that an affine function of a near side leaves at least: friction,
/// backlash and noise see to it; on four measured rigs it is 0.02 and more. A copy of the far side, also one
/// smoothed over three samples, leaves less.
const MIN_LEFT: f64 = 5e-3;

/// Longest delay of a filter that is looked for, samples.
const LONGEST_DELAY: usize = 30;

/// Least correlation whose sign says something.
const CLEAR: f64 = 0.6;

/// Fewest pairs of numbers for a correlation.
const FEWEST: usize = 20;

/// Adds a finding to every log with an input like its far side, and to those with a mirrored far side.
///
/// ```text
/// r(k, d) = correlation of the far side at sample i with input k at sample i + d,   0 <= d <= 30
/// copy:     1 - max over d of r(k, d)^2 < 0.005
/// mirrored: r(k, 0) has the sign that fewer logs have, |r| > 0.6, for an effort k
/// ```
///
/// The delay has the sign of a filter's: an input that comes before the far side is what moves it.
pub(super) fn report_likeness(dataset: &mut Dataset) {
    let inputs = dataset.roles.inputs.clone();
    let far = dataset.roles.far.clone().unwrap_or_default();
    for (k, input) in inputs.iter().enumerate().filter(|(_, input)| input.role != Role::Given) {
        let column = &input.column;
        let of = |log: usize, delay: usize| correlation(&dataset.sequences, log, (k, inputs.len()), delay);
        let together: Vec<Option<f64>> = (0..dataset.logs.len()).map(|log| of(log, 0)).collect();
        let copied: Vec<bool> = (0..dataset.logs.len())
            .map(|log| {
                let mut squares = (0..=LONGEST_DELAY).filter_map(|delay| Some(of(log, delay)?.powi(2)));
                squares.any(|square| 1.0 - square < MIN_LEFT)
            })
            .collect();
        let clear = |sign: f64| together.iter().flatten().filter(|r| sign * **r > CLEAR).count();
        let (alike, opposite) = (clear(1.0), clear(-1.0));
        let rare = if opposite <= alike { -1.0 } else { 1.0 };
        for (log, info) in dataset.logs.iter_mut().enumerate() {
            if copied[log] {
                info.findings.push(format!(
                    "`{column}` is nearly a copy of the far side `{far}`: if it was computed from it, as by \
                        a filter, a model learns nothing of the transmission; leave it with --ignore \
                        {column}"
                ));
            }
            let odd = together[log].is_some_and(|r| rare * r > CLEAR);
            if input.role == Role::Effort && odd && alike.min(opposite) > 0 {
                info.findings.push(format!(
                    "`{far}` and `{column}` rise and fall {} here, unlike in {} other {}: is the sign of \
                        one reversed?",
                    if rare < 0.0 { "oppositely" } else { "together" },
                    alike.max(opposite),
                    if alike.max(opposite) == 1 { "log" } else { "logs" },
                ));
            }
        }
    }
}

/// Pearson correlation of the far side with input `k` of `width`, `delay` samples later, in one log.
fn correlation(sequences: &[Sequence], log: usize, (k, width): (usize, usize), delay: usize) -> Option<f64> {
    let pairs = || {
        let inputs = |s: &Sequence| {
            s.inputs.iter().skip(k + width * delay).step_by(width).copied().collect::<Vec<_>>()
        };
        let of_log = sequences.iter().filter(move |s| s.log == log);
        let pairs = of_log.flat_map(move |s| s.far.iter().copied().zip(inputs(s)));
        pairs.filter(|(far, input)| far.is_finite() && input.is_finite())
    };
    let count = pairs().count();
    if count < FEWEST {
        return None;
    }
    let sums = pairs().fold([0.0; 2], |[a, b], (far, input)| [a + far, b + input]);
    let [mean_far, mean_input] = sums.map(|sum| sum / count as f64);
    let [far, input, both] = pairs().fold([0.0; 3], |[far, input, both], (a, b)| {
        let (a, b) = (a - mean_far, b - mean_input);
        [far + a * a, input + b * b, both + a * b]
    });
    let r = both / (far * input).sqrt();
    r.is_finite().then_some(r)
}
