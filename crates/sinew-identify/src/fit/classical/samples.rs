//! Columns that the classical laws need: one near-side signal, one drive, directions and rates.

use crate::log::{Dataset, Role, Sequence};
use std::ops::Range;

/// Rows that are fitted; the rest of a long log is only used for the score.
const BUDGET: usize = 6_000;
/// Rows kept between two reversals when a log is thinned.
const ROWS_PER_SWING: usize = 50;
/// Fraction of its range by which a signal must turn back to count as reversed.
const REVERSAL: f64 = 0.01;
/// Fraction of the 95 % quantile of the speed below which the drive is at rest.
const REST: f64 = 0.02;
/// Distance from a reversal, in standard deviations of the drive's noise, from which the direction is
/// certain: noise displaces both the extreme and the sample.
const NOISE_MARGIN: f64 = 10.0;

/// Flat columns of all runs, one after the other; `runs` holds the rows of each.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    pub(super) runs: Vec<Range<usize>>,
    /// The sequence of each run; empty where rows were left out.
    pub(super) sequences: Vec<usize>,
    /// The near-side signal that follows the far side best.
    pub(super) near: Vec<f64>,
    /// The near-side tension or torque, where there is one.
    pub(super) effort: Vec<f64>,
    /// Sliding distance up to a constant: the motion, or `near` where none is measured.
    pub(super) drive: Vec<f64>,
    /// Rate of `drive`, unit/s, over five samples.
    pub(super) rate: Vec<f64>,
    /// Sign of the change of `drive`; 0 before its first motion.
    pub(super) direction: Vec<f64>,
    /// Whether the cable slides for certain in that direction: the drive moves, and is further than the dead
    /// band from the reversals before and after.
    pub(super) sliding: Vec<bool>,
    /// Time since the sample before, s; 0 at the start of a run.
    pub(super) interval: Vec<f64>,
    pub(super) far: Vec<f64>,
    /// Rows that are fitted.
    pub(super) fitted: Vec<usize>,
}

/// Names, units and ranges of the columns.
#[derive(Debug, Clone)]
pub(super) struct Signals {
    pub(super) far_unit: String,
    pub(super) near_name: String,
    pub(super) near_unit: String,
    pub(super) drive_name: String,
    pub(super) drive_unit: String,
    pub(super) has_effort: bool,
    /// Whether the effort has the far side's unit, so that a capstan can make one of the other.
    pub(super) effort_is_like_far: bool,
    pub(super) effort_name: String,
    pub(super) effort_unit: String,
    pub(super) effort_range: f64,
    pub(super) has_motion: bool,
    pub(super) near_is_effort: bool,
    pub(super) far_range: f64,
    pub(super) near_range: f64,
    pub(super) drive_range: f64,
    pub(super) reversals: usize,
}

/// Indices of the columns among the inputs.
struct Chosen {
    near: usize,
    effort: Option<usize>,
    drive: usize,
}

/// All samples, the thinned ones for the fit, and their names; a reason where nothing can be fitted.
pub(super) fn gather(data: &Dataset) -> Result<(Samples, Samples, Signals), String> {
    let chosen = choose(data)?;
    let name = |i: usize| data.roles.inputs[i].column.clone();
    let is = |i: usize, role: Role| data.roles.inputs[i].role == role;
    let has_motion = is(chosen.drive, Role::Motion) || is(chosen.drive, Role::Anchor);
    let drive_range =
        range(data.sequences.iter().flat_map(|s| column(data, s, chosen.drive)).collect(), 0.01);
    let mut all = Samples::empty();
    for (place, sequence) in data.sequences.iter().enumerate() {
        if all.append(data, sequence, &chosen, REVERSAL * drive_range) {
            all.sequences.push(place);
        }
    }
    all.find_sliding(REVERSAL * drive_range);
    let effort_name = chosen.effort.map(name).unwrap_or_default();
    let far_name = data.roles.far.as_deref().unwrap_or("");
    let effort_unit = chosen.effort.map_or_else(String::new, |_| unit_of(data, &effort_name));
    let far_unit = unit_of(data, far_name);
    let effort_is_like_far = is_like_far(data, chosen.effort.map(|_| effort_name.as_str()));
    let signals = Signals {
        far_unit,
        near_name: name(chosen.near),
        near_unit: unit_of(data, &name(chosen.near)),
        drive_name: name(chosen.drive),
        drive_unit: unit_of(data, &name(chosen.drive)),
        has_effort: chosen.effort.is_some(),
        effort_is_like_far,
        effort_name,
        effort_unit,
        effort_range: range(all.effort.clone(), 0.01),
        has_motion,
        near_is_effort: is(chosen.near, Role::Effort),
        far_range: range(all.fitted.iter().map(|&i| all.far[i]).collect(), 0.0005),
        near_range: range(all.near.clone(), 0.01),
        drive_range,
        reversals: all.reversals(),
    };
    if all.fitted.len() < 20 {
        return Err(format!("only {} samples can be fitted", all.fitted.len()));
    }
    if signals.far_range <= 0.0 {
        return Err("the far side is constant".to_owned());
    }
    let thinned = all.thinned(signals.reversals);
    Ok((all, thinned, signals))
}

fn choose(data: &Dataset) -> Result<Chosen, String> {
    let best = |roles: &[Role]| -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for (i, input) in data.roles.inputs.iter().enumerate() {
            if !roles.contains(&input.role) {
                continue;
            }
            let follows = correlation(data, i);
            // Ties are resolved by name, so that the order of columns does not matter.
            let better = best.is_none_or(|(j, r)| {
                follows > r || (follows >= r && input.column < data.roles.inputs[j].column)
            });
            if follows > 0.0 && better {
                best = Some((i, follows));
            }
        }
        best
    };
    let near = best(&[Role::Effort, Role::Motion])
        .or_else(|| best(&[Role::Anchor]))
        .ok_or("no near-side effort or motion varies: a constant near side carries no information")?
        .0;
    let effort = best(&[Role::Effort]).map(|(i, _)| i);
    let motion = best(&[Role::Motion]).or_else(|| best(&[Role::Anchor])).map(|(i, _)| i);
    Ok(Chosen { near, effort, drive: motion.unwrap_or(near) })
}

/// |Pearson| of an input with the far side over the scored rows; 0 where either is constant.
fn correlation(data: &Dataset, input: usize) -> f64 {
    let mut comparison = sinew::metrics::Comparison::new();
    for sequence in &data.sequences {
        let pairs = column(data, sequence, input).zip(&sequence.far_clean).zip(&sequence.scored);
        for ((x, &y), &scored) in pairs {
            if scored {
                // Missing values are skipped.
                let _ = comparison.push(y, x);
            }
        }
    }
    comparison.pearson().map_or(0.0, f64::abs)
}

fn column<'a>(data: &Dataset, sequence: &'a Sequence, input: usize) -> impl Iterator<Item = f64> + 'a {
    let width = data.roles.inputs.len().max(1);
    sequence.inputs.iter().skip(input).step_by(width).copied()
}

/// Spread between the quantiles `edge` and `1 - edge`.
pub(super) fn range(mut values: Vec<f64>, edge: f64) -> f64 {
    values.retain(|v| v.is_finite());
    if values.len() < 2 {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    let at = |q: f64| values[(q * (values.len() - 1) as f64).round() as usize];
    at(1.0 - edge) - at(edge)
}

/// Whether an effort measures what the far side does: the same unit, or none stated of one of them.
fn is_like_far(data: &Dataset, effort: Option<&str>) -> bool {
    effort.is_some_and(|effort| {
        let (near, far) = (data.unit(effort), data.unit(data.roles.far.as_deref().unwrap_or("")));
        near == far || near.is_empty() || far.is_empty()
    })
}

/// The unit of a column, or words in its place.
fn unit_of(data: &Dataset, column: &str) -> String {
    let unit = data.unit(column);
    if unit.is_empty() { format!("unit of {column}") } else { unit }
}

impl Signals {
    /// Whether the near-side signal is a tension or torque in the far side's unit.
    pub(super) fn near_is_like_far(&self) -> bool {
        self.near_is_effort && self.effort_is_like_far
    }

    /// The same with the effort as the near-side signal.
    pub(super) fn with_effort_near(&self) -> Self {
        Self {
            near_name: self.effort_name.clone(),
            near_unit: self.effort_unit.clone(),
            near_is_effort: true,
            near_range: self.effort_range,
            ..self.clone()
        }
    }
}

impl Samples {
    /// The same with the effort as the near-side signal.
    pub(super) fn with_effort_near(&self) -> Self {
        Self { near: self.effort.clone(), ..self.clone() }
    }

    fn empty() -> Self {
        Self {
            runs: vec![],
            sequences: vec![],
            near: vec![],
            effort: vec![],
            drive: vec![],
            rate: vec![],
            direction: vec![],
            sliding: vec![],
            interval: vec![],
            far: vec![],
            fitted: vec![],
        }
    }

    /// Whether there was anything to append.
    fn append(&mut self, data: &Dataset, sequence: &Sequence, chosen: &Chosen, dead_band: f64) -> bool {
        let first = self.far.len();
        let near = filled(column(data, sequence, chosen.near));
        let drive = filled(column(data, sequence, chosen.drive));
        let effort = chosen.effort.map_or_else(|| near.clone(), |i| filled(column(data, sequence, i)));
        let n = near.len().min(sequence.time_s.len()).min(sequence.far_clean.len());
        if n == 0 || !(near[0].is_finite() && drive[0].is_finite() && effort[0].is_finite()) {
            return false;
        }
        self.direction.extend(directions(&drive[..n], dead_band));
        for i in 0..n {
            let (back, ahead) = (i.saturating_sub(2), (i + 2).min(n - 1));
            let elapsed = sequence.time_s[ahead] - sequence.time_s[back];
            self.rate.push(if elapsed > 0.0 { (drive[ahead] - drive[back]) / elapsed } else { 0.0 });
            self.interval.push(if i > 0 { sequence.time_s[i] - sequence.time_s[i - 1] } else { 0.0 });
            let row = first + i;
            let counts = sequence.scored.get(i).copied().unwrap_or(false);
            if counts && sequence.far_clean[i].is_finite() && self.direction[row].abs() > 0.0 {
                self.fitted.push(row);
            }
        }
        self.near.extend_from_slice(&near[..n]);
        self.drive.extend_from_slice(&drive[..n]);
        self.effort.extend_from_slice(&effort[..n]);
        self.far.extend_from_slice(&sequence.far_clean[..n]);
        self.runs.push(first..first + n);
        true
    }

    /// Fills [`sliding`](Self::sliding).
    fn find_sliding(&mut self, dead_band: f64) {
        let dead_band = dead_band.max(NOISE_MARGIN * sensor_noise(&self.runs, &self.drive));
        let mut speeds: Vec<f64> = self.rate.iter().map(|rate| rate.abs()).collect();
        speeds.sort_by(f64::total_cmp);
        let fast = speeds.get(speeds.len() * 95 / 100).copied().unwrap_or(0.0);
        self.sliding = vec![false; self.drive.len()];
        for run in &self.runs {
            let mut stroke = run.start;
            for row in run.clone() {
                let ends = row + 1 == run.end || self.direction[row + 1] * self.direction[row] <= 0.0;
                if ends {
                    // The extremes are those of the stroke: a reversal counts from the extreme on.
                    let extremes = [self.drive[stroke.saturating_sub(1).max(run.start)], self.drive[row]];
                    for inner in stroke..=row {
                        let away = extremes.iter().all(|end| (self.drive[inner] - end).abs() > dead_band);
                        self.sliding[inner] = away && self.rate[inner].abs() > REST * fast;
                    }
                    stroke = row + 1;
                }
            }
        }
    }

    /// The same samples with only those to be fitted in which the cable slides for certain.
    pub(super) fn only_sliding(&self) -> Self {
        let fitted = self.fitted.iter().copied().filter(|&row| self.sliding[row]).collect();
        Self { fitted, ..self.clone() }
    }

    /// Number of reversals of the drive, over all runs.
    pub(super) fn reversals(&self) -> usize {
        let turns = |run: &Range<usize>| {
            let directions = &self.direction[run.clone()];
            directions.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count()
        };
        self.runs.iter().map(turns).sum()
    }

    /// At most about [`BUDGET`] rows: first every k-th row while a swing keeps [`ROWS_PER_SWING`], then
    /// stretches spread evenly over the rest, each with a tenth of warm-up that is not fitted.
    fn thinned(&self, reversals: usize) -> Self {
        let rows = self.far.len();
        let requested = rows.div_ceil(BUDGET);
        let affordable = rows / ((reversals + self.runs.len()) * ROWS_PER_SWING).max(1);
        let stride = requested.min(affordable).max(1);
        let piece = 1000 * stride;
        let mut pieces: Vec<(Range<usize>, usize)> = vec![];
        for run in &self.runs {
            let parts = if rows / stride > BUDGET { run.len().div_ceil(piece).max(1) } else { 1 };
            for part in 0..parts {
                let (from, to) = (run.len() * part / parts, run.len() * (part + 1) / parts);
                let warm_up = if part > 0 { (to - from) / 10 } else { 0 };
                pieces.push((run.start + from..run.start + to, run.start + from + warm_up));
            }
        }
        let total: usize = pieces.iter().map(|(rows, _)| rows.len() / stride).sum();
        let every = total.div_ceil(BUDGET + 1000).max(1);
        let mut counts = vec![false; rows];
        for &row in &self.fitted {
            counts[row] = true;
        }
        let mut thin = Self::empty();
        for (rows, from) in pieces.iter().step_by(every) {
            let first = thin.far.len();
            let mut last = rows.start;
            for row in rows.clone().step_by(stride) {
                if row >= *from && counts[row] {
                    thin.fitted.push(thin.far.len());
                }
                let elapsed: f64 = self.interval[last + 1..=row.max(last)].iter().sum();
                thin.interval.push(if row > rows.start { elapsed } else { 0.0 });
                thin.near.push(self.near[row]);
                thin.effort.push(self.effort[row]);
                thin.drive.push(self.drive[row]);
                thin.rate.push(self.rate[row]);
                thin.direction.push(self.direction[row]);
                thin.sliding.push(self.sliding[row]);
                thin.far.push(self.far[row]);
                last = row;
            }
            thin.runs.push(first..thin.far.len());
        }
        thin
    }
}

/// Replaces a missing value by the one before it, leading ones by the first that is present.
fn filled(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    let mut last = values.iter().copied().find(|v| v.is_finite()).unwrap_or(f64::NAN);
    for value in &mut values {
        if value.is_finite() {
            last = *value;
        } else {
            *value = last;
        }
    }
    values
}

/// Standard deviation of a signal's noise, from second differences (a straight line has none).
pub(super) fn sensor_noise(runs: &[Range<usize>], signal: &[f64]) -> f64 {
    let mut bends: Vec<f64> = runs
        .iter()
        .flat_map(|run| signal[run.clone()].windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()))
        .filter(|bend| bend.is_finite())
        .collect();
    if bends.is_empty() {
        return 0.0;
    }
    let middle = bends.len() / 2;
    // Median of |N(0, 6 sigma^2)|.
    *bends.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.6745 * 6.0_f64.sqrt())
}

/// Direction of motion with a dead band against noise, not causal: a reversal counts from the extreme on,
/// although it is detected a dead band later.
fn directions(drive: &[f64], dead_band: f64) -> Vec<f64> {
    let mut found = vec![0.0; drive.len()];
    let (mut direction, mut lowest, mut highest) = (0.0, 0, 0);
    for (i, &x) in drive.iter().enumerate() {
        if x < drive[lowest] {
            lowest = i;
        }
        if x > drive[highest] {
            highest = i;
        }
        if direction <= 0.0 && x > drive[lowest] + dead_band {
            direction = 1.0;
            found[lowest + 1..i].fill(1.0);
            highest = i;
        } else if direction >= 0.0 && x < drive[highest] - dead_band {
            direction = -1.0;
            found[highest + 1..i].fill(-1.0);
            lowest = i;
        }
        found[i] = direction;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_ignore_what_stays_within_the_dead_band() {
        let drive = [0.0, 0.05, 0.0, 1.0, 0.95, 2.0, 1.0, 0.5, 0.55, 3.0];
        let expected = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0];
        assert_eq!(directions(&drive, 0.1), expected);
    }

    #[test]
    fn missing_values_are_filled_by_the_one_before() {
        let values = filled([f64::NAN, 1.0, f64::NAN, 3.0].into_iter());
        assert_eq!(values, [1.0, 1.0, 1.0, 3.0]);
    }
}
