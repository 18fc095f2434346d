//! Columns that are constant within every trial and take several values: conditions of the experiment.

use super::table::Runs;
use super::types::{Condition, Sequence};
use std::collections::BTreeMap;

/// More different values than this make an identifier, not a condition.
const MAX_VALUES: usize = 20;
/// Fewer different values than this are no axis along which to split, unless it is requested.
const MIN_VALUES: usize = 3;

/// What one log offers: columns that are constant within its trials.
pub(super) struct LogConstants {
    /// By column name.
    pub(super) columns: BTreeMap<String, Runs>,
    /// First row of the table in every sequence.
    pub(super) first_rows: Vec<usize>,
}

/// Finds the conditions and writes their values into the sequences; `always` come first, whatever they are.
pub(super) fn find(always: &[&str], logs: &[LogConstants], sequences: &mut [Sequence]) -> Vec<Condition> {
    let Some(first) = logs.first() else { return Vec::new() };
    // BTreeMap: by name, so that the order of the columns changes nothing.
    let names = first.columns.keys().map(String::as_str).filter(|name| !always.contains(name));
    let mut conditions = Vec::new();
    for name in always.iter().copied().chain(names) {
        let Some(values) = values(name, logs) else { continue };
        let mut different: Vec<String> = Vec::new();
        for value in &values {
            if !different.contains(value) {
                different.push(value.clone());
            }
            if different.len() > MAX_VALUES && !always.contains(&name) {
                break;
            }
        }
        if !always.contains(&name) && !(MIN_VALUES..=MAX_VALUES).contains(&different.len()) {
            continue;
        }
        conditions.push(Condition { column: name.to_owned(), values: different });
        for (sequence, value) in sequences.iter_mut().zip(values) {
            sequence.condition_values.push(value);
        }
    }
    conditions
}

/// The value in every sequence, if every log has the column.
fn values(name: &str, logs: &[LogConstants]) -> Option<Vec<String>> {
    let mut values = Vec::new();
    for log in logs {
        let runs = log.columns.get(name)?;
        values.extend(log.first_rows.iter().map(|&row| normal(runs.at(row))));
    }
    Some(values)
}

/// Numbers in their shortest form, so that `10.00` in one log is `10` in another.
fn normal(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => format!("{number}"),
        _ => value.to_owned(),
    }
}
