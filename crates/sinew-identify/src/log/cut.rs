//! A table cut into sequences: at trials, at gaps, without repeated rows.

use super::occurrences::Occurrences;
use super::table::{ColumnLayout, Table};
use super::times::{Times, separating};
use super::types::{ReadOptions, Sequence};
use crate::Error;

/// Fraction of the samples that may be dropped because the one before them has the same time: beyond it the
/// clock is at fault, not single samples.
const MAX_SIMULTANEOUS: f64 = 0.1;

/// What was cut from one log.
pub(super) struct CutLog {
    /// The sequences, `log` and `condition_values` still to be set.
    pub(super) sequences: Vec<Sequence>,
    /// First row of the table in every sequence.
    pub(super) first_rows: Vec<usize>,
    /// Trials found.
    pub(super) trials: usize,
    /// Median sampling interval, s; 0 with a single sample.
    pub(super) interval_s: f64,
    /// What was done, in words.
    pub(super) findings: Vec<String>,
}

/// Cuts a table whose time is scaled to seconds.
pub(super) fn cut(
    file: &str,
    table: &Table,
    layout: ColumnLayout,
    options: &ReadOptions,
) -> Result<CutLog, Error> {
    let times = Times::new(file, table, layout, options.columns.rate_hz)?;
    let mut cutter = Cutter::new(table, layout, options.skip_s, times.gap_s);
    for row in 0..table.lines.len() {
        cutter.row(row, times.at(row));
    }
    let (rows, simultaneous) = (table.lines.len(), cutter.simultaneous.count);
    if simultaneous as f64 > MAX_SIMULTANEOUS * rows as f64 {
        let rate_hz = rows as f64 / ((rows - simultaneous) as f64 * times.interval_s);
        return Err(Error::CoarseTime { file: file.to_owned(), simultaneous, rows, rate_hz });
    }
    let mut findings = times.findings();
    cutter.findings(&mut findings);
    Ok(CutLog {
        sequences: cutter.sequences,
        first_rows: cutter.first_rows,
        trials: cutter.trials,
        interval_s: times.interval_s,
        findings,
    })
}

/// Cuts row by row.
struct Cutter<'a> {
    table: &'a Table,
    layout: ColumnLayout,
    skip_s: f64,
    gap_s: f64,
    sequences: Vec<Sequence>,
    first_rows: Vec<usize>,
    trials: usize,
    next_start: usize,
    trial_start_s: f64,
    last_row: Option<usize>,
    gaps: Occurrences,
    repeated: Occurrences,
    simultaneous: Occurrences,
    without_time: Occurrences,
    skipped: usize,
}

impl<'a> Cutter<'a> {
    fn new(table: &'a Table, layout: ColumnLayout, skip_s: f64, gap_s: f64) -> Self {
        Self {
            table,
            layout,
            skip_s,
            gap_s,
            sequences: Vec::new(),
            first_rows: Vec::new(),
            trials: 0,
            next_start: 0,
            trial_start_s: 0.0,
            last_row: None,
            gaps: Occurrences::default(),
            repeated: Occurrences::default(),
            simultaneous: Occurrences::default(),
            without_time: Occurrences::default(),
            skipped: 0,
        }
    }

    fn row(&mut self, row: usize, time: f64) {
        let line = self.table.lines[row];
        let new_trial = self.new_trial(row);
        if new_trial {
            self.last_row = None;
        }
        if time.is_nan() {
            self.without_time.record(|| format!("line {line}"));
            return;
        }
        let before = self.sequences.last().and_then(|s| s.time_s.last()).copied();
        match (self.last_row, before) {
            (Some(last), Some(before)) => {
                let step = time - before;
                if step <= 0.0 {
                    let occurrences =
                        if self.same(last, row) { &mut self.repeated } else { &mut self.simultaneous };
                    occurrences.record(|| format!("line {line}"));
                    return;
                }
                if step > self.gap_s {
                    self.gaps.record(|| format!("{step:.2} s after {before:.2} s (line {line})"));
                    self.start(row);
                }
            }
            _ => {
                self.trials += 1;
                self.trial_start_s = time;
                self.start(row);
            }
        }
        self.push(row, time);
    }

    /// Whether a new trial starts at `row`, or started at a row before it that was dropped.
    fn new_trial(&mut self, row: usize) -> bool {
        let Some(runs) = separating(self.table) else { return row == 0 };
        match runs.starts.get(self.next_start) {
            Some(&(start, _)) if start <= row => {
                self.next_start += 1;
                true
            }
            _ => false,
        }
    }

    /// Whether two rows hold the same inputs and far side.
    fn same(&self, a: usize, b: usize) -> bool {
        let compared = (0..self.layout.inputs).chain(self.layout.far);
        compared.map(|k| &self.table.numbers[k]).all(|c| c[a].to_bits() == c[b].to_bits())
    }

    fn start(&mut self, row: usize) {
        self.first_rows.push(row);
        self.sequences.push(Sequence {
            log: 0,
            trial: self.table.trial.as_ref().map_or_else(String::new, |t| t.at(row).to_owned()),
            row: Vec::new(),
            time_s: Vec::new(),
            inputs: Vec::new(),
            far: Vec::new(),
            far_clean: Vec::new(),
            scored: Vec::new(),
            condition_values: Vec::new(),
        });
    }

    fn push(&mut self, row: usize, time: f64) {
        let Some(sequence) = self.sequences.last_mut() else { return };
        let far = self.layout.far.map_or(f64::NAN, |k| self.table.numbers[k][row]);
        let skipped = time - self.trial_start_s < self.skip_s;
        self.skipped += usize::from(skipped);
        sequence.row.push(self.table.lines[row]);
        sequence.time_s.push(time);
        sequence.inputs.extend((0..self.layout.inputs).map(|k| self.table.numbers[k][row]));
        sequence.far.push(far);
        sequence.scored.push(!skipped && far.is_finite());
        self.last_row = Some(row);
    }

    fn findings(&self, findings: &mut Vec<String>) {
        let mut report = |occurrences: &Occurrences, one: &str, many: &str| {
            if occurrences.count > 0 {
                let what = if occurrences.count == 1 { one } else { many };
                findings.push(format!("{} {what}: {}", occurrences.count, occurrences.places()));
            }
        };
        report(&self.gaps, "gap, states reset after it", "gaps, states reset after each");
        report(&self.repeated, "repeated row, dropped", "repeated rows, dropped");
        report(
            &self.simultaneous,
            "duplicate timestamp with other values, first kept",
            "duplicate timestamps with other values, first kept",
        );
        report(&self.without_time, "row without a timestamp, dropped", "rows without a timestamp, dropped");
        if self.skipped > 0 {
            findings.push(format!(
                "{} samples in the first {} s of the trials are neither fitted nor scored",
                self.skipped, self.skip_s
            ));
        }
    }
}
