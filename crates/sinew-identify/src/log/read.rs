//! The entry points: logs and roles in, a dataset out.

use super::assemble::{assemble, assemble_references, complete};
use super::names::{Meaning, meaning};
use super::naming;
use super::open::{OpenLog, open_bytes, open_paths};
use super::roles::{self, Columns};
use super::types::{Dataset, ReadOptions, RequestedRoles, Roles};
use super::uses::{self, Label};
use crate::Error;

/// Reads logs whose columns are found by flags and by name.
///
/// The order in which files are given and the order of their columns change nothing.
///
/// # Errors
/// Every way in which a log can be unusable is an [`Error`] of its own that names file, line and column.
pub fn read_dataset(flags: &RequestedRoles, options: &ReadOptions) -> Result<Dataset, Error> {
    with_flags(flags, options, &|| open_paths(&options.paths))
}

/// The same from memory: `logs` are names and contents; [`ReadOptions::paths`] is not used.
///
/// # Errors
/// As [`read_dataset`].
pub fn read_bytes(
    logs: &[(&str, &[u8])],
    flags: &RequestedRoles,
    options: &ReadOptions,
) -> Result<Dataset, Error> {
    with_flags(flags, options, &|| open_bytes(logs))
}

/// Reads logs whose columns are fixed by a model.
///
/// Inputs and time must be there; the far side only if [`ReadOptions::far_required`]; a trial or group
/// column that a log lacks is a finding. A trial column that the model does not name is found by its name.
///
/// # Errors
/// As [`read_dataset`].
pub fn read_with_roles(roles: &Roles, options: &ReadOptions) -> Result<Dataset, Error> {
    with_roles(roles, options, open_paths(&options.paths)?, assemble)
}

/// Reads tables of references with the columns of a model: as [`read_with_roles`], but signals may be
/// constant and few.
///
/// # Errors
/// As [`read_dataset`].
pub fn read_references(roles: &Roles, options: &ReadOptions) -> Result<Dataset, Error> {
    with_roles(roles, options, open_paths(&options.paths)?, assemble_references)
}

/// The same from memory: `logs` are names and contents; [`ReadOptions::paths`] is not used.
///
/// # Errors
/// As [`read_dataset`].
pub fn read_bytes_with_roles(
    logs: &[(&str, &[u8])],
    roles: &Roles,
    options: &ReadOptions,
) -> Result<Dataset, Error> {
    with_roles(roles, options, open_bytes(logs)?, assemble)
}

/// Reads, and reads again without the columns that turned out to be labels.
fn with_flags(
    flags: &RequestedRoles,
    options: &ReadOptions,
    open: &dyn Fn() -> Result<Vec<OpenLog>, Error>,
) -> Result<Dataset, Error> {
    check_skip(options.skip_s)?;
    check_rate(options.columns.rate_hz)?;
    let mut labels: Vec<Label> = Vec::new();
    loop {
        let mut logs = open()?;
        let mut requested = flags.clone();
        naming::name(&mut logs, &options.columns, &asked_for(flags), None)?;
        requested.ignore.extend(labels.iter().map(|label| label.column.clone()));
        if options.columns.rate_hz.is_some() {
            requested.time = None;
        } else if requested.time.is_none() {
            requested.time = roles::time_of(&columns(&logs), &asked_for(&requested))?;
        }
        if let Some(time) = &requested.time {
            naming::same_time(&mut logs, time);
        }
        let found = columns(&logs);
        let roles = roles::find(&requested, &found, options.far_required, options.columns.rate_hz.is_some())?;
        let named = uses::named(&logs);
        let mut dataset = assemble(roles, logs, options)?;
        let new = uses::labels(flags, &dataset);
        if new.is_empty() {
            one_group_is_none(flags, &dataset)?;
            dataset.columns = uses::uses(flags, &labels, &named, &dataset);
            return Ok(dataset);
        }
        labels.extend(new);
    }
}

/// Refuses a group with a single value, along which nothing can be held out.
fn one_group_is_none(flags: &RequestedRoles, dataset: &Dataset) -> Result<(), Error> {
    match dataset.conditions.first() {
        Some(first) if flags.group.as_ref() == Some(&first.column) && first.values.len() < 2 => {
            let value = first.values.first().cloned().unwrap_or_default();
            Err(Error::OneGroup { column: first.column.clone(), value })
        }
        _ => Ok(()),
    }
}

/// How logs with known roles become a dataset.
type Assemble = fn(Roles, Vec<OpenLog>, &ReadOptions) -> Result<Dataset, Error>;

fn with_roles(
    roles: &Roles,
    options: &ReadOptions,
    mut logs: Vec<OpenLog>,
    assemble: Assemble,
) -> Result<Dataset, Error> {
    check_skip(options.skip_s)?;
    check_rate(options.columns.rate_hz)?;
    let mut roles = roles.clone();
    naming::name(&mut logs, &options.columns, &columns_of(&roles), Some(&roles.units))?;
    if options.columns.rate_hz.is_some() {
        roles.time = None;
    } else {
        let time = match &roles.time {
            Some(time) => Some(time.clone()),
            None => roles::time_of(&columns(&logs), &columns_of(&roles))?,
        };
        if let Some(time) = &time {
            naming::same_time(&mut logs, time);
        }
        roles.time = time;
    }
    let columns = columns(&logs);
    let Some(first) = columns.first() else { return Err(Error::NoLogs) };
    if roles.time.is_none() && options.columns.rate_hz.is_none() {
        return Err(Error::NoTime { file: first.file.into(), columns: first.names.to_vec() });
    }
    if options.far_required && roles.far.is_none() {
        return Err(Error::NoFar {
            file: first.file.into(),
            candidates: Vec::new(),
            columns: first.names.to_vec(),
        });
    }
    complete(&roles, &columns, options.far_required)?;
    let has = |name: &String| columns.iter().any(|log| log.names.contains(name));
    roles.far = roles.far.filter(has);
    let known: Vec<&String> =
        roles.inputs.iter().map(|i| &i.column).chain(&roles.far).chain(&roles.time).collect();
    let named = |name: &&String| meaning(name) == Some(Meaning::Trial) && !known.contains(name);
    let found = columns.iter().flat_map(|log| log.names).find(named).cloned();
    roles.trial = roles.trial.filter(has).or(found);
    roles.group = roles.group.filter(has);
    assemble(roles, logs, options)
}

fn columns(logs: &[OpenLog]) -> Vec<Columns<'_>> {
    logs.iter().map(|log| Columns { file: &log.file, names: &log.names, timed: naming::timed(log) }).collect()
}

/// Every column that is asked for by name.
fn asked_for(flags: &RequestedRoles) -> Vec<String> {
    let RequestedRoles { far, effort, motion, anchor, given, time, trial, group, ignore } = flags;
    let single = [far, anchor, time, trial, group].into_iter().flatten();
    single.chain(effort).chain(motion).chain(given).chain(ignore).cloned().collect()
}

/// Every column that a model reads.
fn columns_of(roles: &Roles) -> Vec<String> {
    let inputs = roles.inputs.iter().map(|input| &input.column);
    inputs.chain([&roles.far, &roles.time, &roles.trial].into_iter().flatten()).cloned().collect()
}

fn check_rate(rate_hz: Option<f64>) -> Result<(), Error> {
    match rate_hz {
        Some(got) if !(got.is_finite() && got > 0.0) => {
            let (name, expected) = ("rate", "a finite number of samples per second > 0");
            Err(sinew::Error::OutOfDomain { name, expected, got }.into())
        }
        _ => Ok(()),
    }
}

fn check_skip(skip_s: f64) -> Result<(), Error> {
    if skip_s.is_finite() && skip_s >= 0.0 {
        return Ok(());
    }
    let (name, expected) = ("skip", "a finite number of seconds >= 0");
    Err(sinew::Error::OutOfDomain { name, expected, got: skip_s }.into())
}
