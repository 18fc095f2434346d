//! Which column has which role: as requested, then by the names of `names`.

use super::names::{Meaning, meaning, nearest};
use super::types::{Input, RequestedRoles, Role, Roles};
use crate::{ColumnRole, Error};
use std::collections::{BTreeMap, BTreeSet};

/// A log of which only the columns are known yet.
pub(super) struct Columns<'a> {
    /// Its name.
    pub(super) file: &'a str,
    /// Its columns.
    pub(super) names: &'a [String],
    /// Whether a column is time by its cells or by a unit: `[columns]`.
    pub(super) timed: Vec<bool>,
}

/// Finds the roles in logs that should all have the same columns; time is as requested, or `is_counted`.
pub(super) fn find(
    requested: &RequestedRoles,
    logs: &[Columns<'_>],
    far_required: bool,
    is_counted: bool,
) -> Result<Roles, Error> {
    let Some(first) = logs.first() else { return Err(Error::NoLogs) };
    refuse_two_roles(requested)?;
    // Sorted, so that the order of columns in a file changes nothing.
    let all: BTreeSet<&str> = logs.iter().flat_map(|l| l.names).map(String::as_str).collect();
    let given_inputs = requested_inputs(requested);
    let taken: BTreeSet<&str> = given_inputs
        .iter()
        .map(|input| input.column.as_str())
        .chain([&requested.far, &requested.time, &requested.trial].into_iter().flatten().map(String::as_str))
        .chain(requested.ignore.iter().map(String::as_str))
        .collect();
    let named = |requested: fn(Meaning) -> bool| -> Vec<String> {
        let fits = |name: &&&str| !taken.contains(**name) && meaning(name).is_some_and(requested);
        all.iter().filter(fits).map(|name| (*name).to_owned()).collect()
    };
    let far = match &requested.far {
        Some(far) => Some(far.clone()),
        None => one_far(named(|m| m == Meaning::Far), first, far_required)?,
    };
    let trial = match &requested.trial {
        Some(trial) => Some(trial.clone()),
        None => at_most_one(named(|m| m == Meaning::Trial), first, ColumnRole::Trial)?,
    };
    let inputs = if given_inputs.is_empty() { named_inputs(&named) } else { given_inputs };
    let roles = Roles {
        far,
        inputs,
        time: requested.time.clone(),
        trial,
        group: requested.group.clone(),
        units: BTreeMap::new(),
    };
    present(&roles, logs, far_required)?;
    for column in &requested.ignore {
        known(column, logs)?;
    }
    if roles.inputs.is_empty() {
        return Err(Error::NoInputs { file: first.file.into(), columns: first.names.to_vec() });
    }
    if roles.time.is_none() && !is_counted {
        return Err(Error::NoTime { file: first.file.into(), columns: first.names.to_vec() });
    }
    Ok(roles)
}

/// The time column of logs, of the columns that are not `taken`: by its name, without one by what it holds,
/// and then by a name that is at least like one. Days may call it differently: the name is that of the first
/// log.
///
/// # Errors
/// [`Error::Ambiguous`] where one log has two.
pub(super) fn time_of(logs: &[Columns<'_>], taken: &[String]) -> Result<Option<String>, Error> {
    let means = |name: &String, requested: Meaning| meaning(name) == Some(requested);
    let by_name = |requested: Meaning| move |log: &Columns<'_>, c: usize| means(&log.names[c], requested);
    let (named, like) = (by_name(Meaning::Time), by_name(Meaning::TimeLike));
    let held = |log: &Columns<'_>, c: usize| log.timed[c];
    type Tier<'a> = &'a dyn Fn(&Columns<'_>, usize) -> bool;
    let tiers: [Tier<'_>; 3] = [&named, &held, &like];
    for tier in tiers {
        let mut found = None;
        for log in logs {
            let fits = (0..log.names.len()).filter(|&c| !taken.contains(&log.names[c]) && tier(log, c));
            let time = at_most_one(fits.map(|c| log.names[c].clone()).collect(), log, ColumnRole::Time)?;
            found = found.or(time);
        }
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

fn requested_inputs(requested: &RequestedRoles) -> Vec<Input> {
    let of = |names: &[String], role: Role| -> Vec<Input> {
        names.iter().map(|column| Input { column: column.clone(), role }).collect()
    };
    let mut inputs = of(&requested.effort, Role::Effort);
    inputs.extend(of(&requested.motion, Role::Motion));
    inputs.extend(of(requested.anchor.as_slice(), Role::Anchor));
    inputs.extend(of(&requested.given, Role::Given));
    inputs
}

fn named_inputs(named: &dyn Fn(fn(Meaning) -> bool) -> Vec<String>) -> Vec<Input> {
    let of = |requested: fn(Meaning) -> bool, role: Role| {
        named(requested).into_iter().map(move |column| Input { column, role })
    };
    of(|m| m == Meaning::Input(Role::Effort), Role::Effort)
        .chain(of(|m| m == Meaning::Input(Role::Motion), Role::Motion))
        .chain(of(|m| m == Meaning::Input(Role::Anchor), Role::Anchor))
        .chain(of(|m| m == Meaning::Input(Role::Given), Role::Given))
        .collect()
}

fn one_far(mut named: Vec<String>, log: &Columns<'_>, required: bool) -> Result<Option<String>, Error> {
    if named.len() > 1 || required && named.is_empty() {
        return Err(Error::NoFar { file: log.file.into(), candidates: named, columns: log.names.to_vec() });
    }
    Ok(named.pop())
}

fn at_most_one(mut named: Vec<String>, log: &Columns<'_>, role: ColumnRole) -> Result<Option<String>, Error> {
    if named.len() > 1 {
        return Err(Error::Ambiguous { file: log.file.into(), role, candidates: named });
    }
    Ok(named.pop())
}

/// A column can have one role, but the group may be a column that is used otherwise too.
fn refuse_two_roles(requested: &RequestedRoles) -> Result<(), Error> {
    let mut given: Vec<(&str, ColumnRole)> = Vec::new();
    given.extend(requested.far.iter().map(|c| (c.as_str(), ColumnRole::Far)));
    given.extend(requested.effort.iter().map(|c| (c.as_str(), ColumnRole::Effort)));
    given.extend(requested.motion.iter().map(|c| (c.as_str(), ColumnRole::Motion)));
    given.extend(requested.anchor.iter().map(|c| (c.as_str(), ColumnRole::Anchor)));
    given.extend(requested.given.iter().map(|c| (c.as_str(), ColumnRole::Given)));
    given.extend(requested.time.iter().map(|c| (c.as_str(), ColumnRole::Time)));
    given.extend(requested.trial.iter().map(|c| (c.as_str(), ColumnRole::Trial)));
    given.extend(requested.ignore.iter().map(|c| (c.as_str(), ColumnRole::Ignored)));
    for (i, &(column, second)) in given.iter().enumerate() {
        if let Some(&(_, first)) = given[..i].iter().find(|&&(other, _)| other == column) {
            return Err(Error::TwoRoles { column: column.into(), first, second });
        }
    }
    match &requested.group {
        Some(group) if requested.far.as_ref() == Some(group) => {
            Err(Error::TwoRoles { column: group.clone(), first: ColumnRole::Far, second: ColumnRole::Group })
        }
        Some(group) if requested.time.as_ref() == Some(group) => {
            Err(Error::TwoRoles { column: group.clone(), first: ColumnRole::Time, second: ColumnRole::Group })
        }
        _ => Ok(()),
    }
}

/// Every column with a role, and whether a log may lack it.
pub(super) fn needed(roles: &Roles, far_required: bool) -> Vec<(&str, bool)> {
    let mut needed: Vec<(&str, bool)> = Vec::new();
    needed.extend(roles.far.iter().map(|c| (c.as_str(), !far_required)));
    needed.extend(roles.inputs.iter().map(|i| (i.column.as_str(), false)));
    needed.extend(roles.time.iter().map(|c| (c.as_str(), false)));
    needed.extend(roles.trial.iter().map(|c| (c.as_str(), false)));
    needed.extend(roles.group.iter().map(|c| (c.as_str(), false)));
    needed
}

/// Refuses logs that lack a column which is not `optional`.
fn present(roles: &Roles, logs: &[Columns<'_>], far_required: bool) -> Result<(), Error> {
    for (column, optional) in needed(roles, far_required) {
        one_column(column, optional, logs)?;
    }
    Ok(())
}

/// Refuses a column to be ignored that no log has: a slip of the pen would leave the column meant in its
/// role.
fn known(column: &str, logs: &[Columns<'_>]) -> Result<(), Error> {
    let here = |log: &Columns<'_>| log.names.iter().any(|name| name == column);
    if logs.iter().any(here) { Ok(()) } else { one_column(column, false, logs) }
}

/// Refuses logs that lack `column`, or have it twice.
pub(super) fn one_column(column: &str, optional: bool, logs: &[Columns<'_>]) -> Result<(), Error> {
    let count = |log: &Columns<'_>| log.names.iter().filter(|name| *name == column).count();
    if let Some(log) = logs.iter().find(|log| count(log) > 1) {
        return Err(Error::SameName { file: log.file.into(), column: column.into() });
    }
    if optional {
        return Ok(());
    }
    let Some(without) = logs.iter().find(|log| count(log) == 0) else { return Ok(()) };
    match logs.iter().find(|log| count(log) == 1) {
        Some(with) => Err(Error::ColumnsDiffer {
            file: without.file.into(),
            other: with.file.into(),
            lacking: with.names.iter().filter(|n| !without.names.contains(n)).cloned().collect(),
            columns: without.names.to_vec(),
        }),
        None => Err(Error::MissingColumn {
            file: without.file.into(),
            column: column.into(),
            nearest: nearest(column, without.names).map(str::to_owned),
            columns: without.names.to_vec(),
        }),
    }
}
