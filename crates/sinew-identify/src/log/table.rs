//! What is kept of a log while it streams by: numbers asked for, labels, and possible conditions.

use std::borrow::Cow;
use std::collections::HashMap;

/// Columns to keep, by their index in the log.
#[derive(Debug, Clone, Default)]
pub(super) struct Requested {
    /// Columns that must be numbers.
    pub(super) numbers: Vec<usize>,
    /// The one of them whose cells are stamps of time.
    pub(super) stamped: Option<usize>,
    /// The trial column.
    pub(super) trial: Option<usize>,
    /// The group column.
    pub(super) group: Option<usize>,
    /// Columns that could be conditions.
    pub(super) candidates: Vec<usize>,
}

/// A column of text that changes seldom, as runs of equal values.
#[derive(Debug, Clone, Default)]
pub(super) struct Runs {
    /// First row of every run, and its value as an index into `values`.
    pub(super) starts: Vec<(usize, usize)>,
    /// The different values, in order of appearance.
    pub(super) values: Vec<String>,
    index: HashMap<Box<[u8]>, usize>,
    current: Vec<u8>,
}

impl Runs {
    /// Adds `row` with `value`; true where a new run starts.
    pub(super) fn push(&mut self, row: usize, value: &[u8]) -> bool {
        if !self.starts.is_empty() && self.current == value {
            return false;
        }
        self.current.clear();
        self.current.extend_from_slice(value);
        let id = match self.index.get(value) {
            Some(&id) => id,
            None => {
                let id = self.values.len();
                self.index.insert(value.into(), id);
                self.values.push(String::from_utf8_lossy(value).trim().to_owned());
                id
            }
        };
        self.starts.push((row, id));
        true
    }

    /// The value at `row`.
    pub(super) fn at(&self, row: usize) -> &str {
        let run = self.starts.partition_point(|&(start, _)| start <= row);
        let id = run.checked_sub(1).and_then(|r| self.starts.get(r)).map(|&(_, id)| id);
        id.and_then(|id| self.values.get(id)).map_or("", String::as_str)
    }
}

/// The part of a log that was asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    /// One column per entry of [`Requested::numbers`]; NaN where a cell is empty.
    pub(super) numbers: Vec<Vec<f64>>,
    /// Line (text) or row (binary) of every row, from 1.
    pub(super) lines: Vec<usize>,
    /// The trial column.
    pub(super) trial: Option<Runs>,
    /// The group column.
    pub(super) group: Option<Runs>,
    /// Columns that are constant within every trial (or group, or log): their index and values.
    pub(super) constants: Vec<(usize, Runs)>,
    /// What the format's reader did, in words.
    pub(super) findings: Vec<String>,
}

/// Where the columns of the roles stand in [`Table::numbers`].
#[derive(Debug, Clone, Copy)]
pub(super) struct ColumnLayout {
    /// The inputs are columns `0..inputs`.
    pub(super) inputs: usize,
    /// The far side.
    pub(super) far: Option<usize>,
    /// Time.
    pub(super) time: Option<usize>,
}

/// Fills a [`Table`] row by row.
///
/// Per row: [`begin`](Self::begin), then `trial`, `group`, numbers and candidates in this order.
pub(super) struct TableBuilder {
    table: Table,
    block_starts: bool,
}

impl TableBuilder {
    /// An empty table for what is `requested`.
    pub(super) fn new(requested: &Requested) -> Self {
        let table = Table {
            numbers: vec![Vec::new(); requested.numbers.len()],
            trial: requested.trial.map(|_| Runs::default()),
            group: requested.group.map(|_| Runs::default()),
            constants: requested.candidates.iter().map(|&c| (c, Runs::default())).collect(),
            ..Table::default()
        };
        Self { table, block_starts: false }
    }

    /// Starts a row.
    pub(super) fn begin(&mut self, line: usize) {
        self.block_starts = self.table.lines.is_empty();
        self.table.lines.push(line);
    }

    fn row(&self) -> usize {
        self.table.lines.len().saturating_sub(1)
    }

    /// The trial label of the row.
    pub(super) fn trial(&mut self, value: &[u8]) {
        let row = self.row();
        if let Some(runs) = &mut self.table.trial {
            self.block_starts |= runs.push(row, value);
        }
    }

    /// The group label of the row; without a trial column it separates sequences.
    pub(super) fn group(&mut self, value: &[u8]) {
        let row = self.row();
        let separates = self.table.trial.is_none();
        if let Some(runs) = &mut self.table.group {
            let starts = runs.push(row, value);
            self.block_starts |= separates && starts;
        }
    }

    /// A number of the row.
    pub(super) fn number(&mut self, k: usize, value: f64) {
        self.table.numbers[k].push(value);
    }

    /// Offers every possible condition its value; one that changes within a trial is none.
    pub(super) fn candidates<'a>(&mut self, mut value: impl FnMut(usize) -> Cow<'a, [u8]>) {
        let (row, block_starts) = (self.row(), self.block_starts);
        self.table.constants.retain_mut(|(column, runs)| {
            let starts = runs.push(row, &value(*column));
            block_starts || !starts
        });
    }

    /// Rows so far.
    pub(super) fn rows(&self) -> usize {
        self.table.lines.len()
    }

    /// The table, with the findings of its reader.
    pub(super) fn finish(mut self, findings: Vec<String>) -> Table {
        self.table.findings = findings;
        self.table
    }
}
