//! Channels that stand still while the others move: at the bound of a sensor, or frozen for a stretch.

use super::times::quantile;
use super::types::{Dataset, Defect, DefectKind, Role};

/// Fewest equal samples in a row that are a plateau at an extreme.
const SHORTEST_AT_BOUND: usize = 3;
/// Fewest samples at a bound.
const FEWEST_AT_BOUND: usize = 8;
/// Fewest equal samples in a row that are a frozen stretch.
const SHORTEST_FROZEN: usize = 10;
/// Fraction of its range by which another channel goes on while one stands at its bound.
const GOES_ON: f64 = 0.06;
/// Fraction of its range by which a channel turns while a frozen one stands.
const TURNS: f64 = 0.15;
/// Samples before a plateau over which its speed is taken.
const BEFORE: usize = 4;
/// Speed times duration of a peak that is seen in quanta, quanta.
const PEAK: f64 = 4.0;
/// Least correlation that says in which direction two channels go.
const CLEAR: f64 = 0.3;
/// Fraction of the samples on plateaus during which another goes on, from which the plateaus are those of a
/// sensor.
const MOST: f64 = 0.3;
/// A jump at the end of a frozen stretch, over the step that 95 % of the steps do not exceed.
const JUMP: f64 = 3.0;
/// Expected number of runs as long by chance, below which a run is none.
const CHANCE: f64 = 1e-6;

/// One channel of a log, sequence after sequence.
struct Channel {
    name: String,
    is_effort: bool,
    /// `[sequence][sample]`.
    values: Vec<Vec<f64>>,
    low: f64,
    high: f64,
    /// Smallest difference of two values; 0 where it is not above a thousandth of the range.
    quantum: f64,
}

/// Equal samples in a row.
#[derive(Debug, Clone, Copy)]
struct Plateau {
    sequence: usize,
    start: usize,
    end: usize,
}

impl Plateau {
    fn len(&self) -> usize {
        self.end - self.start
    }
}

/// Adds a defect for every channel that is clipped or frozen.
///
/// ```text
/// clipped: runs of >= 3 equal samples at the extreme of a channel, come to faster than to a peak seen in quanta, during
///          which another channel goes on outwards: what sticks stops where the other turns, and what rests, rests with
///          the others
/// frozen:  a run of L equal samples with n p^L < 1e-6, p the fraction of equal neighbours elsewhere, that starts or ends with
///          a jump, or in which another channel turns, of a channel that stands nowhere else
/// ```
pub(super) fn report_plateaus(dataset: &mut Dataset) {
    for log in 0..dataset.logs.len() {
        let rows: Vec<Vec<usize>> =
            dataset.sequences.iter().filter(|s| s.log == log).map(|s| s.row.clone()).collect();
        let times: Vec<Vec<f64>> =
            dataset.sequences.iter().filter(|s| s.log == log).map(|s| s.time_s.clone()).collect();
        let channels = channels(dataset, log);
        for k in 0..channels.len() {
            let plateaus = plateaus(&channels[k].values);
            let mut clipped = false;
            for is_high in [true, false] {
                if let Some(defect) = clipped_at(&channels, k, &plateaus, is_high, &rows) {
                    dataset.logs[log].add(defect);
                    clipped = true;
                }
            }
            if let (false, Some(defect)) = (clipped, frozen(&channels, k, &plateaus, &rows, &times)) {
                dataset.logs[log].add(defect);
            }
        }
    }
}

/// The channels of a log that move: inputs but the given ones, and the far side.
fn channels(dataset: &Dataset, log: usize) -> Vec<Channel> {
    let width = dataset.roles.inputs.len();
    let sequences = || dataset.sequences.iter().filter(|s| s.log == log);
    let inputs = dataset.roles.inputs.iter().enumerate().filter(|(_, input)| input.role != Role::Given);
    let mut found: Vec<Channel> = inputs
        .filter_map(|(k, input)| {
            let values = sequences().map(|s| s.inputs.iter().skip(k).step_by(width).copied().collect());
            Channel::new(&input.column, input.role == Role::Effort, values.collect())
        })
        .collect();
    if let Some(far) = &dataset.roles.far {
        found.extend(Channel::new(far, true, sequences().map(|s| s.far.clone()).collect()));
    }
    found
}

impl Channel {
    /// `None` where it does not move.
    fn new(name: &str, is_effort: bool, values: Vec<Vec<f64>>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().flatten().copied().filter(|x| x.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (low, high) = (*sorted.first()?, *sorted.last()?);
        let least = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
        let quantum = if least > 1e-3 * (high - low) { least } else { 0.0 };
        (high > low).then(|| Self { name: name.to_owned(), is_effort, values, low, high, quantum })
    }

    fn range(&self) -> f64 {
        self.high - self.low
    }

    /// Means of blocks of a plateau, where there are samples enough to average noise; empty where a number is
    /// missing.
    fn blocks(&self, Plateau { sequence, start, end }: Plateau) -> Vec<f64> {
        let part = &self.values[sequence][start..end];
        if part.iter().any(|x| !x.is_finite()) || part.len() < SHORTEST_AT_BOUND {
            return Vec::new();
        }
        let block = if part.len() >= 9 { part.len() / (part.len() / 3).min(9) } else { 1 };
        part.chunks_exact(block).map(|b| b.iter().sum::<f64>() / b.len() as f64).collect()
    }

    /// How far the channel goes up from where it is at the start of a plateau, and how far down: fractions of
    /// its range.
    fn goes(&self, plateau: Plateau) -> [f64; 2] {
        let means = self.blocks(plateau);
        let Some(first) = means.first() else { return [0.0; 2] };
        let (low, high) =
            means.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        [(high - first) / self.range(), (first - low) / self.range()]
    }

    /// Whether the channel goes out and comes back within a plateau, up or down, by a fraction of its range.
    fn turns(&self, plateau: Plateau) -> bool {
        let means = self.blocks(plateau);
        let (Some(first), Some(last)) = (means.first(), means.last()) else { return false };
        let (low, high) =
            means.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        (high - first.max(*last)).max(first.min(*last) - low) > TURNS * self.range()
    }

    /// Whether the channel comes to a plateau faster than to a peak that is seen in quanta: there, speed
    /// times duration is at most four quanta.
    fn arrives(&self, Plateau { sequence, start, end }: Plateau) -> bool {
        let values = &self.values[sequence];
        let before = start.saturating_sub(BEFORE);
        if before == start {
            return true;
        }
        let speed = (values[start] - values[before]).abs() / (start - before) as f64;
        speed * (end - start) as f64 > 2.0 * PEAK * self.quantum
    }

    /// Sign of the correlation with another channel; 0 where it says nothing.
    fn sign(&self, other: &Self) -> f64 {
        let mut comparison = sinew::metrics::Comparison::new();
        for (a, b) in self.values.iter().flatten().zip(other.values.iter().flatten()) {
            // Missing values are skipped.
            let _ = comparison.push(*a, *b);
        }
        comparison.pearson().filter(|r| r.abs() > CLEAR).map_or(0.0, f64::signum)
    }
}

/// All runs of at least three equal numbers.
fn plateaus(values: &[Vec<f64>]) -> Vec<Plateau> {
    let mut found = Vec::new();
    for (sequence, values) in values.iter().enumerate() {
        let mut start = 0;
        for i in 1..=values.len() {
            if i == values.len() || values[i].to_bits() != values[start].to_bits() {
                if i - start >= SHORTEST_AT_BOUND && values[start].is_finite() {
                    found.push(Plateau { sequence, start, end: i });
                }
                start = i;
            }
        }
    }
    found
}

/// The defect of a channel that stands at its highest, or lowest, value while another goes on.
fn clipped_at(
    channels: &[Channel],
    k: usize,
    plateaus: &[Plateau],
    is_high: bool,
    rows: &[Vec<usize>],
) -> Option<Defect> {
    let channel = &channels[k];
    let bound = if is_high { channel.high } else { channel.low };
    // A slack cable has no tension: zero is no bound of a sensor.
    if !is_high && channel.is_effort && bound == 0.0 {
        return None;
    }
    let at_bound: Vec<Plateau> = plateaus
        .iter()
        .filter(|p| channel.values[p.sequence][p.start].total_cmp(&bound).is_eq())
        .copied()
        .collect();
    let samples: usize = at_bound.iter().map(Plateau::len).sum();
    if samples < FEWEST_AT_BOUND {
        return None;
    }
    let least = GOES_ON.max(3.0 * channel.quantum / channel.range());
    let others = || channels.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| other);
    let passed = |other: &Channel| -> usize {
        let sign = channel.sign(other);
        // Outwards: a far side that sticks at its highest value sees the near side go down and come back.
        let way = usize::from((sign > 0.0) != is_high);
        let went_on = |p: &&Plateau| sign != 0.0 && channel.arrives(**p) && other.goes(**p)[way] > least;
        at_bound.iter().filter(went_on).map(Plateau::len).sum()
    };
    let (other, passed) = others().map(|other| (other, passed(other))).max_by_key(|(_, passed)| *passed)?;
    if (passed as f64) < MOST * samples as f64 || passed < FEWEST_AT_BOUND {
        return None;
    }
    let first = at_bound.first()?;
    let line = rows[first.sequence][first.start];
    let total: usize = channel.values.iter().map(Vec::len).sum();
    let sentence = format!(
        "`{}` is clipped at {bound}: {samples} of {total} samples, from line {line} on, stand exactly there \
            while `{}` goes on; beyond it the model cannot tell what happens, and its errors there do not \
            show",
        channel.name, other.name
    );
    Some(Defect { kind: DefectKind::Clipped, column: channel.name.clone(), line: Some(line), sentence })
}

/// The defect of a channel that stands still for a stretch.
fn frozen(
    channels: &[Channel],
    k: usize,
    plateaus: &[Plateau],
    rows: &[Vec<usize>],
    times: &[Vec<f64>],
) -> Option<Defect> {
    let channel = &channels[k];
    let longest = plateaus.iter().max_by_key(|p| p.len()).filter(|p| p.len() >= SHORTEST_FROZEN)?;
    let (mut pairs, mut equal) = (0_usize, 0_usize);
    let mut steps: Vec<f64> = Vec::new();
    for (sequence, values) in channel.values.iter().enumerate() {
        for i in 1..values.len() {
            let inside = sequence == longest.sequence && (longest.start..longest.end).contains(&i);
            let step = (values[i] - values[i - 1]).abs();
            if inside || !step.is_finite() {
                continue;
            }
            pairs += 1;
            if step > 0.0 { steps.push(step) } else { equal += 1 }
        }
    }
    let chance = (equal.max(1) as f64 / pairs.max(1) as f64).min(1.0);
    let expected = pairs as f64 * chance.powi(i32::try_from(longest.len()).unwrap_or(i32::MAX) - 1);
    if expected > CHANCE {
        return None;
    }
    let others = || channels.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| other);
    let moved = |other: &Channel| {
        let part =
            other.values[longest.sequence][longest.start..longest.end].iter().filter(|x| x.is_finite());
        let (low, high) = part.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        (high - low) / other.range()
    };
    let other = others().max_by(|a, b| moved(a).total_cmp(&moved(b))).filter(|other| moved(other) > 0.1)?;
    let values = &channel.values[longest.sequence];
    let step_at =
        |i: usize| if i == 0 || i >= values.len() { 0.0 } else { (values[i] - values[i - 1]).abs() };
    let jump = step_at(longest.start).max(step_at(longest.end));
    let usual = quantile(&mut steps, 0.95);
    let jumps = jump > JUMP * usual && jump > 0.02 * channel.range();
    let stands_nowhere_else = plateaus.len() == 1 && chance < 0.02;
    if !(jumps || stands_nowhere_else && others().any(|other| other.turns(*longest))) {
        return None;
    }
    let lines = &rows[longest.sequence];
    let (from, to) = (lines[longest.start], lines[longest.end - 1]);
    let seconds = times[longest.sequence][longest.end - 1] - times[longest.sequence][longest.start];
    let sentence = format!(
        "`{}` is frozen at {} from line {from} to {to} ({seconds:.2} s) while `{}` moves by {:.0} % of its \
            range: a sensor or its transfer hung, and the model learns a standstill that was none",
        channel.name,
        values[longest.start],
        other.name,
        100.0 * moved(other)
    );
    Some(Defect { kind: DefectKind::Frozen, column: channel.name.clone(), line: Some(from), sentence })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str, values: Vec<f64>) -> Channel {
        Channel::new(name, true, vec![values]).expect("it moves")
    }

    /// Near side, and a far side that follows with play: it stands wherever the near side turns.
    fn bench(n: usize) -> (Vec<f64>, Vec<f64>) {
        let near: Vec<f64> =
            (0..n).map(|i| 60.0 + (2.0 + (i as f64 * 7e-4).sin()) * 10.0 * (i as f64 * 0.05).sin()).collect();
        let mut far = near[0];
        let follow = |u: &f64| {
            far = far.clamp(0.8 * u, 0.95 * u);
            far
        };
        let far = near.iter().map(follow).collect();
        (near, far)
    }

    fn found(near: Vec<f64>, far: Vec<f64>) -> Vec<(DefectKind, Option<usize>)> {
        let rows = vec![(0..near.len()).map(|i| i + 2).collect::<Vec<_>>()];
        let times = vec![(0..near.len()).map(|i| i as f64 * 0.01).collect::<Vec<_>>()];
        let channels = [channel("near", near), channel("far", far)];
        let mut all = Vec::new();
        for k in 0..2 {
            let plateaus = plateaus(&channels[k].values);
            all.extend(
                [true, false].iter().filter_map(|high| clipped_at(&channels, k, &plateaus, *high, &rows)),
            );
            if all.is_empty() {
                all.extend(frozen(&channels, k, &plateaus, &rows, &times));
            }
        }
        all.into_iter().map(|defect| (defect.kind, defect.line)).collect()
    }

    #[test]
    fn a_far_side_that_sticks_is_neither_clipped_nor_frozen() {
        let (near, far) = bench(2000);
        assert_eq!(found(near.clone(), far.clone()), []);
        // In counts of a coarse converter, too.
        let coarse = |x: &f64| (x / 0.5).round() * 0.5;
        assert_eq!(found(near.iter().map(coarse).collect(), far.iter().map(coarse).collect()), []);
        assert_eq!(found(near[..150].to_vec(), far[..150].to_vec()), []);
    }

    #[test]
    fn a_bound_of_either_side_is_named_with_its_first_line() {
        let (near, far) = bench(2000);
        let first = near.iter().position(|x| *x >= 75.0).expect("reached") + 2;
        let clip = |values: &[f64], low: f64, high: f64| {
            values.iter().map(|x| x.clamp(low, high)).collect::<Vec<_>>()
        };
        assert_eq!(found(clip(&near, 0.0, 75.0), far.clone()), [(DefectKind::Clipped, Some(first))]);
        assert_eq!(found(near.clone(), clip(&far, 0.0, 62.0)).len(), 1);
        assert_eq!(found(clip(&near, 45.0, 1e3), far).len(), 1);
    }

    #[test]
    fn a_frozen_stretch_is_named_and_rest_of_all_is_not() {
        let (near, far) = bench(2000);
        let hold = |values: &[f64], from: usize, to: usize| {
            let mut held = values.to_vec();
            held[from..to].fill(values[from]);
            held
        };
        assert_eq!(found(hold(&near, 500, 610), far.clone()), [(DefectKind::Frozen, Some(502))]);
        assert_eq!(found(near.clone(), hold(&far, 500, 560)), [(DefectKind::Frozen, Some(502))]);
        assert_eq!(found(hold(&near, 500, 610), hold(&far, 500, 610)), []);
    }
}
