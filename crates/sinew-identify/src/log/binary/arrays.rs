//! Named arrays, as MATLAB keeps them, to columns of one table.

use super::array::Array;
use crate::Error;
use crate::log::occurrences::counted;
use crate::log::table::{Requested, Table, TableBuilder};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A log whose columns are in memory.
pub(in crate::log) struct ArrayLog {
    file: String,
    columns: Vec<String>,
    data: Vec<Vec<f64>>,
    rows: usize,
    findings: Vec<String>,
}

/// More columns than this are no log.
const MAX_COLUMNS: usize = 10_000;

impl ArrayLog {
    /// The arrays of a MATLAB v5 file.
    pub(in crate::log) fn from_mat5(file: &str, bytes: &[u8]) -> Result<Self, Error> {
        Self::new(file, super::mat5::arrays(file, bytes)?)
    }

    /// The arrays of a MATLAB v7.3 file.
    #[cfg(feature = "mat73")]
    pub(in crate::log) fn from_mat73(file: &str, bytes: Vec<u8>) -> Result<Self, Error> {
        Self::new(file, super::mat73::arrays(file, bytes)?)
    }

    /// Vectors of the most frequent length are columns; matrices with as many rows give `name_1`, `name_2`,
    /// ...; single numbers are columns that do not change; the rest is left out and reported.
    fn new(file: &str, arrays: Vec<Array>) -> Result<Self, Error> {
        let Some(rows) = table_length(&arrays) else {
            return Err(Error::Malformed {
                file: file.into(),
                line: None,
                expected: "vectors of equal length, in the file itself or in structs".into(),
                got: "no numeric vector (cells, tables, objects and text are not read)".into(),
            });
        };
        let mut log =
            Self { file: file.to_owned(), columns: Vec::new(), data: Vec::new(), rows, findings: Vec::new() };
        let short = short_names(&arrays);
        let mut left_out = Vec::new();
        for (array, name) in arrays.into_iter().zip(short) {
            if !log.add(array, &name) {
                left_out.push(name);
            }
        }
        if !left_out.is_empty() {
            let count = left_out.len();
            left_out.truncate(5);
            let names = left_out.join("`, `");
            log.findings.push(format!(
                "left out {} of another size than {rows} samples, such as `{names}`",
                counted(count, "array")
            ));
        }
        Ok(log)
    }

    /// Adds the columns of an array; false where its size does not fit.
    fn add(&mut self, array: Array, name: &str) -> bool {
        let Array { rows, columns, data, .. } = array;
        let n = self.rows;
        if data.len() == 1 {
            self.push(name.to_owned(), vec![data[0]; n]);
        } else if data.len() == n {
            self.push(name.to_owned(), data);
        } else if (rows == n || columns == n) && n > 0 && data.len().is_multiple_of(n) {
            let others = data.len() / n;
            if self.columns.len() + others > MAX_COLUMNS {
                return false;
            }
            for k in 0..others {
                let column = if rows == n {
                    data[k * n..(k + 1) * n].to_vec()
                } else {
                    data.iter().skip(k).step_by(others).copied().collect()
                };
                self.push(format!("{name}_{}", k + 1), column);
            }
        } else {
            return false;
        }
        true
    }

    fn push(&mut self, name: String, column: Vec<f64>) {
        self.columns.push(name);
        self.data.push(column);
    }

    /// Column names.
    pub(in crate::log) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of rows.
    pub(in crate::log) fn rows(&self) -> u64 {
        self.rows as u64
    }

    /// Reads what is `requested`.
    pub(in crate::log) fn read(self, requested: &Requested) -> Result<Table, Error> {
        let mut builder = TableBuilder::new(requested);
        let mut labels: Vec<Label> = vec![Label::default(); self.columns.len()];
        for row in 0..self.rows {
            builder.begin(row + 1);
            if let Some(column) = requested.trial {
                builder.trial(labels[column].of(self.data[column][row]));
            }
            if let Some(column) = requested.group {
                builder.group(labels[column].of(self.data[column][row]));
            }
            for (k, &column) in requested.numbers.iter().enumerate() {
                builder.number(k, self.number(row, column)?);
            }
            builder.candidates(|column| Cow::Owned(labels[column].of(self.data[column][row]).to_vec()));
        }
        Ok(builder.finish(self.findings))
    }

    fn number(&self, row: usize, column: usize) -> Result<f64, Error> {
        let value = self.data[column][row];
        if value.is_infinite() {
            return Err(Error::NotFinite {
                file: self.file.clone(),
                line: row + 1,
                column: self.columns[column].clone(),
                value: value.to_string(),
            });
        }
        Ok(value)
    }
}

/// A number as a label, written anew only where it changes.
#[derive(Clone, Default)]
struct Label {
    bits: Option<u64>,
    text: String,
}

impl Label {
    fn of(&mut self, value: f64) -> &[u8] {
        if self.bits != Some(value.to_bits()) {
            self.bits = Some(value.to_bits());
            self.text = if value.is_nan() { String::new() } else { value.to_string() };
        }
        self.text.as_bytes()
    }
}

/// The length that most vectors share, those of a matrix included; the longest of them where several do.
fn table_length(arrays: &[Array]) -> Option<usize> {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for array in arrays.iter().filter(|a| a.data.len() > 1) {
        // A log is longer than wide, however a matrix lies.
        let (short, long) = (array.rows.min(array.columns), array.rows.max(array.columns));
        *counts.entry(long).or_default() += short;
    }
    counts.into_iter().max_by_key(|&(length, count)| (count, length)).map(|(length, _)| length)
}

/// Names without the structs around them, where that leaves them different.
fn short_names(arrays: &[Array]) -> Vec<String> {
    let last = |path: &str| path.rsplit('.').next().unwrap_or(path).to_owned();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for array in arrays {
        *counts.entry(last(&array.path)).or_default() += 1;
    }
    let short = |array: &Array| {
        let name = last(&array.path);
        if counts.get(&name) == Some(&1) { name } else { array.path.clone() }
    };
    arrays.iter().map(short).collect()
}
