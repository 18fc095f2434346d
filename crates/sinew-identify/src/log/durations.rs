//! Logs that are too short, and logs whose clock differs from the others'.

use super::types::{Dataset, Defect, DefectKind, Sequence};

/// Seconds below which a log shows no motion that a model could be judged by.
const SHORTEST_S: f64 = 0.5;

/// Deviation of single sampling intervals from their median up to which a log is sampled evenly.
const EVEN: f64 = 0.02;

/// Deviation of a ratio of intervals from a simple fraction up to which it is one: a rate that was chosen. Of
/// a large whole number it is [`WHOLE`] at most, or every ratio would be near one.
const SIMPLE: f64 = 0.005;
const WHOLE: f64 = 0.05;

/// Largest ratio of two rates of one bench, and largest numerator and denominator of a fraction that is one.
const MAX_TIMES: f64 = 100.0;
const SMALL: u32 = 5;

/// Adds a defect to every log that is too short, and to evenly sampled ones whose interval fits no rate
/// beside those of the others.
pub(super) fn report_durations(dataset: &mut Dataset) {
    let of_log = |log: usize| dataset.sequences.iter().filter(move |s| s.log == log);
    let lengths: Vec<(f64, usize)> = (0..dataset.logs.len())
        .map(|log| (of_log(log).map(duration).sum(), of_log(log).map(|s| s.row.len()).sum()))
        .collect();
    let intervals: Vec<Option<f64>> = (0..dataset.logs.len()).map(|log| even_interval(of_log(log))).collect();
    let time = dataset.roles.time.clone().unwrap_or_default();
    for (log, (seconds, samples)) in lengths.into_iter().enumerate() {
        if seconds < SHORTEST_S {
            let sentence = format!(
                "{seconds:.2} s of data in {samples} samples: too short to show friction in both directions, \
                    so that errors beyond what it happens to hold are not seen"
            );
            dataset.logs[log].add(Defect::of_log(DefectKind::Short, "", sentence));
        }
        if let (Some(own), Some(others)) = (intervals[log], agreed(&intervals, log))
            && !is_simple(own / others)
        {
            let sentence = format!(
                "`{time}` advances by {:.4} ms from sample to sample, in the other logs by {:.4} ms: if this \
                    is another clock or unit, speeds and time constants of this log are wrong by a factor of \
                    {:.3}",
                1e3 * own,
                1e3 * others,
                own / others
            );
            dataset.logs[log].add(Defect::of_log(DefectKind::Clock, &time, sentence));
        }
    }
}

fn duration(sequence: &Sequence) -> f64 {
    sequence.time_s.last().zip(sequence.time_s.first()).map_or(0.0, |(last, first)| last - first)
}

/// The interval of an evenly sampled log.
fn even_interval<'a>(sequences: impl Iterator<Item = &'a Sequence>) -> Option<f64> {
    let mut steps: Vec<f64> = sequences.flat_map(|s| s.time_s.windows(2).map(|w| w[1] - w[0])).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let at = |fraction: f64| steps.get((fraction * steps.len() as f64) as usize).copied();
    let (slow, middle, fast) = (at(0.9)?, at(0.5)?, at(0.1)?);
    (steps.len() >= 20 && slow - fast < EVEN * middle).then_some(middle)
}

/// The interval that at least two other logs have, and no other one lacks.
fn agreed(intervals: &[Option<f64>], log: usize) -> Option<f64> {
    let others: Option<Vec<f64>> =
        intervals.iter().enumerate().filter(|(k, _)| *k != log).map(|(_, interval)| *interval).collect();
    let others = others.filter(|others| others.len() >= 2)?;
    let (low, high) = others.iter().fold((f64::MAX, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    (high - low < EVEN * low).then_some(low)
}

/// Whether a ratio of two intervals is that of two usual rates: a whole number, or of two small ones.
fn is_simple(ratio: f64) -> bool {
    let near = |ratio: f64, most: f64| {
        let whole = ratio.round();
        (1.0..=most).contains(&whole) && (ratio - whole).abs() < WHOLE.min(SIMPLE * whole)
    };
    near(ratio, MAX_TIMES)
        || near(ratio.recip(), MAX_TIMES)
        || (1..=SMALL).any(|k| near(ratio * f64::from(k), SMALL.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_ratios_of_rates_are_simple_and_those_of_clocks_are_not() {
        for ratio in [1.0, 2.0, 0.1, 0.2, 1.5, 10.0, 0.01, 1.004, 0.8, 24.02, 100.04] {
            assert!(is_simple(ratio), "{ratio}");
        }
        for ratio in [1000.0, 1e-3, 1.37, 1.037, 24.1, 73.2] {
            assert!(!is_simple(ratio), "{ratio}");
        }
    }
}
