//! Time of every row, checked to increase, and its regularity.

use super::table::{ColumnLayout, Runs, Table};
use crate::Error;

/// A pause longer than this many median sampling intervals, and longer than [`GAP_TYPICAL`] times the
/// interval that 95 % of the samples keep, is a gap: states are not carried over it.
///
/// At 100 Hz this is one second; a log at 2 Hz that skips a sample now and then is not cut.
pub const GAP_INTERVALS: f64 = 100.0;
/// See [`GAP_INTERVALS`].
pub const GAP_TYPICAL: f64 = 5.0;

/// The labels that separate trials: the trial column, or without one the group column.
pub(super) fn separating(table: &Table) -> Option<&Runs> {
    table.trial.as_ref().or(table.group.as_ref())
}

/// Time of every row, checked to increase, and its regularity.
pub(super) struct Times<'a> {
    time: Option<&'a [f64]>,
    /// Median sampling interval, s.
    pub(super) interval_s: f64,
    slow_s: f64,
    fast_s: f64,
    /// A longer step is a gap, s.
    pub(super) gap_s: f64,
}

impl<'a> Times<'a> {
    /// Checks the time column.
    pub(super) fn new(
        file: &str,
        table: &'a Table,
        layout: ColumnLayout,
        rate_hz: Option<f64>,
    ) -> Result<Self, Error> {
        let Some(column) = layout.time else {
            let Some(rate_hz) = rate_hz else {
                return Err(Error::NoTime { file: file.to_owned(), columns: Vec::new() });
            };
            let interval_s = rate_hz.recip();
            let [slow_s, fast_s] = [interval_s; 2];
            return Ok(Self { time: None, interval_s, slow_s, fast_s, gap_s: f64::INFINITY });
        };
        let time = table.numbers[column].as_slice();
        let mut steps = forward_steps(file, table, time)?;
        let interval_s = quantile(&mut steps, 0.5);
        let slow_s = quantile(&mut steps, 0.95);
        let fast_s = quantile(&mut steps, 0.05);
        let gap_s = (GAP_INTERVALS * interval_s).max(GAP_TYPICAL * slow_s);
        Ok(Self { time: Some(time), interval_s, slow_s, fast_s, gap_s })
    }

    /// Time of a row, s.
    pub(super) fn at(&self, row: usize) -> f64 {
        self.time.map_or(row as f64 * self.interval_s, |time| time[row])
    }

    /// What is irregular, in words.
    pub(super) fn findings(&self) -> Vec<String> {
        if self.time.is_none() {
            return vec![format!(
                "time is counted as requested, {:.3} ms from sample to sample; no time column is read",
                1e3 * self.interval_s
            )];
        }
        if self.slow_s > 1.5 * self.fast_s {
            return vec![format!(
                "sampling is irregular: {:.3} ms in the median, 5 % below {:.3} ms and 5 % above {:.3} ms",
                1e3 * self.interval_s,
                1e3 * self.fast_s,
                1e3 * self.slow_s
            )];
        }
        Vec::new()
    }
}

/// Positive time steps within trials; a negative one is an error.
fn forward_steps(file: &str, table: &Table, time: &[f64]) -> Result<Vec<f64>, Error> {
    let starts = separating(table).map_or(&[][..], |runs| runs.starts.as_slice());
    let mut starts = starts.iter().map(|&(row, _)| row).peekable();
    let mut steps = Vec::with_capacity(time.len());
    let (mut first, mut before) = (f64::NAN, f64::NAN);
    for (row, &now) in time.iter().enumerate() {
        if starts.next_if(|&start| start <= row).is_some() {
            (first, before) = (f64::NAN, f64::NAN);
        }
        if now.is_nan() {
            continue;
        }
        if now < before {
            let (file, line) = (file.to_owned(), table.lines[row]);
            let again = separating(table).is_none() && now <= first + 0.1 * (before - first);
            return Err(if again {
                Error::StackedTrials { file, line, before, after: now }
            } else {
                Error::TimeBackwards { file, line, before, after: now }
            });
        }
        if now > before {
            steps.push(now - before);
        }
        if first.is_nan() {
            first = now;
        }
        before = now;
    }
    Ok(steps)
}

/// The value below which a fraction `q` of `values` lies; 0 of nothing.
pub(super) fn quantile(values: &mut [f64], q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let k = (q * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}
