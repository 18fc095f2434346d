//! One name and one unit for what several logs, or the logs and a request or a model, hold under different
//! ones.

use super::names::{Meaning, meaning};
use super::open::OpenLog;
use super::types::ColumnOptions;
use super::units::{self, bracketed, contradict, factor, plain, split_unit, unit_of};
use crate::Error;
use std::collections::BTreeMap;

/// Renames columns and sets units as requested, then brings names that differ in their unit alone to one: to
/// that of `requested`, or else of the first log. Numbers in another unit of the same kind are converted.
///
/// # Errors
/// [`Error::MissingColumn`] for a column of the options that no log has, [`Error::UnknownUnit`]; with
/// `units`, those of a model's columns whose names do not state them, [`Error::OtherUnit`].
pub(super) fn name(
    logs: &mut [OpenLog],
    options: &ColumnOptions,
    requested: &[String],
    units: Option<&BTreeMap<String, String>>,
) -> Result<(), Error> {
    let unit_in =
        |name: &str| units.and_then(|units| units.get(name)).cloned().unwrap_or_else(|| unit_of(name));
    for (old, new) in &options.rename {
        let places = holding(logs, old)?;
        for (log, column) in places {
            logs[log].findings.push(format!("`{old}` is read as `{new}`, as requested"));
            logs[log].names[column].clone_from(new);
        }
    }
    // A requested name is a reference too: it may lack the unit that the files state, or state one that they
    // lack.
    for name in requested {
        unify(logs, name, &unit_in(name));
    }
    for (column, unit) in &options.units {
        let is_time = |log: &OpenLog, c: usize| is_time(&log.names[c]) || units::is_time(&log.units[c]);
        for (log, c) in holding(logs, column)? {
            let (known, expected) = if is_time(&logs[log], c) {
                (units::is_time(unit), ["s", "ms", "us", "ns", "min"].map(str::to_owned).to_vec())
            } else {
                (units::is_known(unit), units::names())
            };
            if !known {
                return Err(Error::UnknownUnit {
                    column: column.clone(),
                    unit: unit.clone(),
                    known: expected,
                });
            }
            logs[log].units[c].clone_from(unit);
        }
    }
    for k in 0..logs.len() {
        for c in 0..logs[k].names.len() {
            let (name, unit) = (logs[k].names[c].clone(), logs[k].units[c].clone());
            unify(logs, &name, &unit);
        }
    }
    let names: Vec<String> =
        requested.iter().chain(logs.iter().flat_map(|log| &log.names)).cloned().collect();
    for name in names {
        let reference = Some(unit_in(&name)).filter(|unit| requested.contains(&name) && !unit.is_empty());
        convert(logs, &name, reference, units.is_some())?;
    }
    Ok(())
}

/// Where a column stands that the options name: log and column.
fn holding(logs: &mut [OpenLog], column: &str) -> Result<Vec<(usize, usize)>, Error> {
    if logs.iter().all(|log| !log.names.iter().any(|name| name == column)) {
        unify(logs, column, &unit_of(column));
    }
    let places: Vec<(usize, usize)> = logs
        .iter()
        .enumerate()
        .filter_map(|(k, log)| Some((k, log.names.iter().position(|name| name == column)?)))
        .collect();
    match (places.is_empty(), logs.first()) {
        (true, Some(first)) => Err(Error::MissingColumn {
            file: first.file.clone(),
            column: column.to_owned(),
            nearest: super::names::nearest(column, &first.names).map(str::to_owned),
            columns: first.names.clone(),
        }),
        _ => Ok(places),
    }
}

/// Gives `name` to the one column of every log without it whose name differs in its unit alone.
fn unify(logs: &mut [OpenLog], name: &str, unit: &str) {
    let base = base(name);
    // Where some log has both, they are two columns.
    let with: Vec<String> = logs
        .iter()
        .filter(|log| log.names.iter().any(|n| n == name))
        .flat_map(|log| log.names.clone())
        .collect();
    for log in logs.iter_mut().filter(|log| log.names.iter().all(|n| n != name)) {
        let alike: Vec<usize> = (0..log.names.len())
            .filter(|&c| self::base(&log.names[c]) == base && !with.contains(&log.names[c]))
            .filter(|&c| factor(&log.units[c], unit).is_some())
            .collect();
        if let [only] = alike[..] {
            name.clone_into(&mut log.names[only]);
        }
    }
}

/// The name without its unit.
fn base(name: &str) -> String {
    bracketed(name).map_or_else(|| split_unit(&plain(name)).0.to_owned(), |(before, _)| plain(before))
}

/// Converts the numbers of a column to the unit in which it was `requested`, or to that of the first log.
///
/// # Errors
/// [`Error::OtherUnit`] where a model has it in a unit of something else.
fn convert(logs: &mut [OpenLog], name: &str, requested: Option<String>, by_model: bool) -> Result<(), Error> {
    // Time is converted to seconds, whatever the others have.
    if is_time(name) {
        return Ok(());
    }
    let place = |log: &OpenLog| log.names.iter().position(|n| n == name);
    let first =
        logs.iter().find_map(|log| place(log).map(|c| log.units[c].clone()).filter(|unit| !unit.is_empty()));
    let fixed = by_model && requested.is_some();
    // What a log states outweighs what looks like a unit in a name, such as the `A` of `LC-A`.
    let fits = |unit: &String| fixed || first.as_ref().is_none_or(|first| factor(first, unit).is_some());
    let Some(reference) = requested.filter(fits).or(first) else { return Ok(()) };
    for log in logs.iter_mut() {
        let Some(c) = place(log) else { continue };
        let factor = factor(&log.units[c], &reference);
        if fixed && contradict(&log.units[c], &reference) {
            let (file, column, unit) = (log.file.clone(), name.to_owned(), log.units[c].clone());
            return Err(Error::OtherUnit { file, column, unit, expected: reference });
        }
        let Some(factor) = factor.filter(|factor| (factor - 1.0).abs() > 1e-12) else { continue };
        log.factors[c] = factor;
        log.findings.push(format!(
            "`{name}` was multiplied by {factor} to have {reference} in place of {}",
            std::mem::replace(&mut log.units[c], reference.clone())
        ));
    }
    Ok(())
}

fn is_time(name: &str) -> bool {
    matches!(meaning(name), Some(Meaning::Time | Meaning::TimeLike))
}

/// Whether a column holds stamps of time, or has a unit of time by a row of units: `[columns]`.
pub(super) fn timed(log: &OpenLog) -> Vec<bool> {
    (0..log.names.len())
        .map(|c| log.is_stamped(c) || units::is_time(&log.units[c]) && unit_of(&log.names[c]).is_empty())
        .collect()
}

/// Gives the name of the time column to the one column of every other log that means time.
pub(super) fn same_time(logs: &mut [OpenLog], time: &str) {
    for log in logs.iter_mut().filter(|log| log.names.iter().all(|name| name != time)) {
        let timed = timed(log);
        let of = |requested: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..log.names.len()).filter(|&c| requested(c)).collect()
        };
        let meant = |meant: Meaning| of(&|c| meaning(&log.names[c]) == Some(meant));
        let found = [meant(Meaning::Time), of(&|c| timed[c]), meant(Meaning::TimeLike)];
        if let Some([only]) = found.iter().find(|columns| !columns.is_empty()).map(Vec::as_slice) {
            log.findings.push(format!("`{}` is the time, which is `{time}` elsewhere", log.names[*only]));
            time.clone_into(&mut log.names[*only]);
        }
    }
}
