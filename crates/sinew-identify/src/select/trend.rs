//! A trend of friction from log to log: the next one will be beyond all of them.

use super::agreement::relative;
use super::candidates::cell_recipe;
use crate::conditioning::ConditionedLogs;
use crate::estimation::rmse;
use crate::fit::run::Run;
use crate::log::{Defect, DefectKind, Role};
use crate::training::{fit, fit_law};
use rayon::prelude::*;
use sinew::predictor::{Memory, MemoryLaw};

/// Least change per log that is a trend: beyond it are no two days of one rig.
const LEAST: f64 = 0.04;

/// Largest fraction of the variance that a straight line leaves.
const LEAVES: f64 = 0.15;

/// Fewest logs: three are in order by chance in a third of all cases.
const FEWEST: usize = 4;

/// Error of a log's own cell, over the standard deviation of its far side, beyond which its width means
/// nothing.
const FITS: f64 = 0.15;

/// Adds a defect to the last log where the width of the hysteresis rises or falls from every log to the next.
///
/// ```text
/// w_k = mean band of a clamp cell fitted to log k / that of one cell fitted to all, on the samples of log k
/// ln w_k = a + b k,   trend: w monotone, |b| > ln 1.04, and the line leaves less than 15 % of the variance
/// ```
///
/// The order is that of the numbers in the names. Nothing is judged where a given quantity or a condition
/// differs between the logs: it may be the reason.
pub(crate) fn report_trend(logs: &mut ConditionedLogs) {
    let count = logs.data.logs.len();
    if count < FEWEST || differs(logs) {
        return;
    }
    let recipe = cell_recipe(logs);
    let of_log = |log: usize| -> Vec<&Run> { logs.runs.iter().filter(|run| run.log == log).collect() };
    let all: Vec<&Run> = logs.runs.iter().collect();
    let Some(common) = fit_law(&recipe, &all) else { return };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&log| natural(&logs.data.logs[log].name));
    let widths: Vec<Option<f64>> = order
        .par_iter()
        .map(|&log| {
            let estimator = fit(&recipe, &of_log(log), 0)?;
            let law = &estimator.law;
            if relative(rmse(&estimator, &of_log(log)), &logs.runs, log) > FITS {
                return None;
            }
            let ratio = width(law, &of_log(log))? / width(&common, &of_log(log))?;
            (ratio > 0.0 && ratio.is_finite()).then(|| ratio.ln())
        })
        .collect();
    let Some(widths) = widths.into_iter().collect::<Option<Vec<f64>>>() else { return };
    let Some(slope) = trend(&widths) else { return };
    let percent = 100.0 * (slope.exp() - 1.0);
    let way = if slope > 0.0 { "rises" } else { "falls" };
    let (Some(first), Some(last)) = (order.first(), order.last()) else { return };
    let far = logs.data.roles.far.clone().unwrap_or_default();
    let sentence = format!(
        "the hysteresis of `{far}` {way} by {:.0} % a log, from {} to {}: the next will be beyond all of \
            them, and its error larger than expected; find the cause, or identify from the latest logs and \
            adapt",
        percent.abs(),
        logs.data.logs[*first].name,
        logs.data.logs[*last].name
    );
    logs.data.logs[*last].add(Defect::of_log(DefectKind::Trend, &far, sentence));
}

/// Whether the logs differ in a given quantity or a condition.
fn differs(logs: &ConditionedLogs) -> bool {
    !logs.data.conditions.is_empty() || logs.data.roles.inputs.iter().any(|input| input.role == Role::Given)
}

/// Slope of a line through the points at 0, 1, 2, ...; `None` where they are no trend.
fn trend(points: &[f64]) -> Option<f64> {
    let n = points.len() as f64;
    let steps = points.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, most) =
        steps.fold((f64::MAX, f64::MIN), |(least, most), step| (least.min(step), most.max(step)));
    if points.len() < FEWEST || least * most <= 0.0 {
        return None;
    }
    let (middle, mean) = (0.5 * (n - 1.0), points.iter().sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (k, y) in points.iter().enumerate() {
        let (x, y) = (k as f64 - middle, y - mean);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let slope = xy / xx;
    let leaves = 1.0 - xy * xy / (xx * yy);
    (slope.abs() > (1.0 + LEAST).ln() && leaves < LEAVES).then_some(slope)
}

/// Mean width of the band of a law along runs.
fn width(law: &MemoryLaw, runs: &[&Run]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        let mut memory = Memory::new(law);
        for i in 0..run.len() {
            memory.step(law, run.dt_s[i], run.row(i));
            sum += memory.cell().high - memory.cell().low;
            count += 1.0;
        }
    }
    (count > 0.0).then_some(sum / count)
}

/// A name cut into text and numbers, so that `day10` comes after `day9`.
fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts = vec![(String::new(), 0_u64)];
    let mut in_number = false;
    for c in name.chars() {
        let last = parts.len() - 1;
        if let Some(digit) = c.to_digit(10) {
            parts[last].1 = parts[last].1.saturating_mul(10).saturating_add(u64::from(digit));
            in_number = true;
        } else if in_number {
            parts.push((c.to_string(), 0));
            in_number = false;
        } else {
            parts[last].0.push(c);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_rise_is_a_trend_and_days_that_differ_are_none() {
        let rise: Vec<f64> = (0..5).map(|k| 0.077 * f64::from(k)).collect();
        assert!(trend(&rise).is_some_and(|slope| (slope - 0.077).abs() < 1e-12));
        assert!(trend(&[0.0, -0.08, -0.16, -0.24]).is_some_and(|slope| slope < 0.0));
        assert_eq!(trend(&[0.0, 0.03, 0.06, 0.09]), None, "days of one rig");
        assert_eq!(trend(&[0.0, 0.15, 0.1, 0.2]), None, "not from every log to the next");
        assert_eq!(trend(&[0.0, 0.01, 0.02, 0.4]), None, "no line");
        assert_eq!(trend(&[0.0, 0.1, 0.2]), None, "three logs are in order by chance");
    }

    #[test]
    fn names_are_ordered_by_their_numbers() {
        assert!(natural("day9.csv") < natural("day10.csv"));
        assert!(natural("a2") < natural("b1"));
    }
}
