//! One log or trial: its sequences joined, with a row of NaN at every gap.

use super::format::{axis_label, bare, unit, unit_of};
use sinew_identify::report::{IdentificationReport, Trace};

/// The cross-validated prediction over one log or trial. All vectors have the same length; a gap is a row of
/// NaN.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub(super) log: String,
    pub(super) trial: String,
    /// Log and trial as one name.
    pub(super) label: String,
    pub(super) time_s: Vec<f64>,
    pub(super) near: Vec<f64>,
    /// The other inputs, in the order of [`Signals::others`].
    pub(super) others: Vec<Vec<f64>>,
    pub(super) far: Vec<f64>,
    pub(super) predicted: Vec<f64>,
    pub(super) half_width: Vec<f64>,
    pub(super) gate: Vec<f64>,
    pub(super) near_rate: Vec<f64>,
    pub(super) since_reversal_s: Vec<f64>,
    pub(super) scored: Vec<bool>,
}

/// Sums of errors over scored samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Score {
    pub(super) samples: usize,
    squares: f64,
    inside: usize,
    banded: usize,
    widths: f64,
}

impl Score {
    /// Root mean square error; NaN without samples.
    pub(super) fn rmse(&self) -> f64 {
        (self.squares / self.samples as f64).sqrt()
    }

    /// Fraction of the samples within the band; NaN without samples.
    pub(super) fn coverage(&self) -> f64 {
        self.inside as f64 / self.banded as f64
    }

    /// Mean half width of the band; NaN without samples.
    pub(super) fn half_width(&self) -> f64 {
        self.widths / self.banded as f64
    }

    /// Adds other samples.
    pub(super) fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.squares += other.squares;
        self.inside += other.inside;
        self.banded += other.banded;
        self.widths += other.widths;
    }
}

impl Record {
    /// Rows, breaks included.
    pub(super) fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Predicted minus measured.
    pub(super) fn error(&self, i: usize) -> f64 {
        self.predicted[i] - self.far[i]
    }

    /// Indices of the samples by which axes are scaled: the scored ones; all, where none is scored.
    pub(super) fn scaling(&self) -> Vec<usize> {
        let scored: Vec<usize> = (0..self.len()).filter(|&i| self.scored_error(i).is_finite()).collect();
        if scored.is_empty() { (0..self.len()).collect() } else { scored }
    }

    /// The error, or NaN where the sample is not scored.
    pub(super) fn scored_error(&self, i: usize) -> f64 {
        if self.scored[i] { self.error(i) } else { f64::NAN }
    }

    /// Sums over the scored samples.
    pub(super) fn score(&self) -> Score {
        let mut score = Score::default();
        for i in 0..self.len() {
            let error = self.scored_error(i);
            if error.is_finite() {
                score.samples += 1;
                score.squares += error * error;
                if self.half_width[i].is_finite() {
                    score.banded += 1;
                    score.inside += usize::from(error.abs() <= self.half_width[i]);
                    score.widths += self.half_width[i];
                }
            }
        }
        score
    }

    /// Whether the gate ever reduced the learned correction.
    pub(super) fn gated(&self) -> bool {
        self.gate.iter().any(|g| *g < 0.995)
    }

    fn append(&mut self, trace: &Trace) {
        let n = trace.time_s.len().min(trace.far.len()).min(trace.predicted.len());
        if n > 0 && self.len() > 0 {
            self.break_here();
        }
        let limit = 10.0 * median_step(&trace.time_s);
        for i in 0..n {
            if i > 0 && trace.time_s[i] - trace.time_s[i - 1] > limit {
                self.break_here();
            }
            let get = |column: &[f64]| column.get(i).copied().unwrap_or(f64::NAN);
            self.push([
                trace.time_s[i],
                get(&trace.near),
                trace.far[i],
                trace.predicted[i],
                get(&trace.half_width),
                get(&trace.gate),
                get(&trace.near_rate),
                get(&trace.since_reversal_s),
            ]);
            self.scored.push(trace.scored.get(i).copied().unwrap_or(true));
            for (column, other) in self.others.iter_mut().zip(&trace.others) {
                column.push(get(&other.values));
            }
        }
    }

    fn push(&mut self, row: [f64; 8]) {
        let columns = [
            &mut self.time_s,
            &mut self.near,
            &mut self.far,
            &mut self.predicted,
            &mut self.half_width,
            &mut self.gate,
            &mut self.near_rate,
            &mut self.since_reversal_s,
        ];
        columns.into_iter().zip(row).for_each(|(column, value)| column.push(value));
    }

    /// A row of NaN after the last one; its time is finite, so that an axis can show the gap.
    fn break_here(&mut self) {
        let time = self.time_s.last().copied().unwrap_or(f64::NAN);
        let mut row = [f64::NAN; 8];
        row[0] = time;
        self.push(row);
        self.others.iter_mut().for_each(|column| column.push(f64::NAN));
        // A gap has no error and no score, but is not an interval excluded from scoring.
        self.scored.push(true);
    }
}

fn median_step(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).filter(|d| d.is_finite()).collect();
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The report's traces, the sequences of one log and trial joined in order of time.
pub(super) fn records(report: &IdentificationReport) -> Vec<Record> {
    let mut records: Vec<Record> = Vec::new();
    let one_log = report.traces.windows(2).all(|w| w[0].log == w[1].log);
    for trace in &report.traces {
        let same = |r: &Record| r.log == trace.log && r.trial == trace.trial;
        let parts = records.iter().filter(|r| same(r)).count();
        let first = trace.time_s.first().copied().unwrap_or(f64::NAN);
        match records.iter_mut().rfind(|r| same(r)) {
            Some(record) if record.time_s.last().is_none_or(|last| first > *last) => record.append(trace),
            _ => {
                let mut record = Record {
                    log: trace.log.clone(),
                    trial: trace.trial.clone(),
                    others: vec![Vec::new(); trace.others.len()],
                    ..Record::default()
                };
                record.label = label(if one_log { "" } else { &trace.log }, trace, parts);
                record.append(trace);
                records.push(record);
            }
        }
    }
    records
}

/// Log and trial, without the part that is the same for all records.
fn label(log: &str, trace: &Trace, parts: usize) -> String {
    let mut label = match (log.is_empty(), trace.trial.is_empty()) {
        (false, false) => format!("{log} · {}", trace.trial),
        (true, false) => trace.trial.clone(),
        (_, true) => trace.log.clone(),
    };
    if parts > 0 {
        label.push_str(&format!(" (part {})", parts + 1));
    }
    label
}

/// Names and units of the far and near signals.
#[derive(Debug, Clone)]
pub(super) struct Signals {
    pub(super) far: String,
    pub(super) far_unit: &'static str,
    pub(super) near: String,
    pub(super) near_unit: &'static str,
    /// Names of the other inputs.
    pub(super) others: Vec<String>,
    other_units: Vec<&'static str>,
}

impl Signals {
    pub(super) fn new(report: &IdentificationReport) -> Self {
        let near = match report.traces.first().map(|t| t.near_name.as_str()) {
            Some(name) if !name.is_empty() => name.to_owned(),
            _ => report.inputs.first().map_or_else(|| "near side".to_owned(), |i| i.column.clone()),
        };
        let others =
            report.traces.first().map(|t| t.others.iter().map(|other| other.column.clone()).collect());
        let others: Vec<String> = others.unwrap_or_default();
        // Of a name without one the logs may state it.
        let stated =
            |column: &str, said: &str| Some(unit_of(column)).filter(|u| !u.is_empty()).unwrap_or(unit(said));
        let unit_of_input = |column: &str| {
            let used = report.columns.iter().find(|used| used.column == column);
            stated(column, used.map_or("", |used| used.unit.as_str()))
        };
        Self {
            far: report.far.clone(),
            far_unit: stated(&report.far, &report.far_unit),
            near_unit: unit_of_input(&near),
            near,
            other_units: others.iter().map(|column| unit_of_input(column)).collect(),
            others,
        }
    }

    /// `measured (N)` for the far side, so that axis and legend agree.
    pub(super) fn far_label(&self) -> String {
        axis_label(&self.far, self.far_unit)
    }

    /// Name and unit of the near-side signal.
    pub(super) fn near_label(&self) -> String {
        axis_label(&self.near, self.near_unit)
    }

    /// Names and units of the other inputs.
    pub(super) fn other_labels(&self) -> impl Iterator<Item = String> {
        self.others.iter().zip(&self.other_units).map(|(name, unit)| axis_label(name, unit))
    }

    /// Name and unit of the near-side signal's rate.
    pub(super) fn rate_label(&self) -> String {
        match self.near_unit {
            "" => format!("rate of {}", self.near),
            unit => format!("rate of {} ({unit}/s)", bare(&self.near)),
        }
    }

    /// A label with the far side's unit.
    pub(super) fn in_far_unit(&self, what: &str) -> String {
        match self.far_unit {
            "" => what.to_owned(),
            unit => format!("{what} ({unit})"),
        }
    }
}
