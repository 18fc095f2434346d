//! The account of the columns: which has which role, in which unit, and why; labels among the motions by
//! name.

use super::names::{Meaning, meaning};
use super::open::OpenLog;
use super::types::{ColumnUse, Dataset, RequestedRoles, Role};
use crate::ColumnRole;

/// A moving part takes more different positions than this; a label of its direction or phase does not.
const MAX_LABELS: usize = 3;

/// A column that its name makes a motion and its values a label.
pub(super) struct Label {
    pub(super) column: String,
    values: Vec<f64>,
}

/// A column of the logs with its unit, as found before any role.
pub(super) struct Named {
    column: String,
    unit: String,
}

/// Every column of all logs.
pub(super) fn named(logs: &[OpenLog]) -> Vec<Named> {
    let mut all: Vec<Named> = Vec::new();
    for (column, unit) in logs.iter().flat_map(|log| log.names.iter().zip(&log.units)) {
        match all.iter_mut().find(|known| known.column == *column) {
            None => all.push(Named { column: column.clone(), unit: unit.clone() }),
            Some(known) if known.unit.is_empty() => known.unit.clone_from(unit),
            Some(_) => {}
        }
    }
    all
}

/// Motions by name alone that take two or three values.
pub(super) fn labels(requested: &RequestedRoles, dataset: &Dataset) -> Vec<Label> {
    let inputs = &dataset.roles.inputs;
    let by_name = |column: &String| !requested.motion.contains(column);
    let motions = inputs.iter().enumerate().filter(|(_, i)| i.role == Role::Motion && by_name(&i.column));
    let found = motions.map(|(k, input)| {
        let signals = dataset.sequences.iter().flat_map(|s| s.inputs.iter().skip(k).step_by(inputs.len()));
        Label { column: input.column.clone(), values: few_values(signals) }
    });
    found.filter(|label| label.values.len() > 1).collect()
}

/// The different numbers in ascending order; none where they are more than [`MAX_LABELS`].
fn few_values<'a>(signal: impl Iterator<Item = &'a f64>) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for x in signal.map(|x| x + 0.0).filter(|x| x.is_finite()) {
        if values.iter().all(|v| v.to_bits() != x.to_bits()) {
            values.push(x);
        }
        if values.len() > MAX_LABELS {
            return Vec::new();
        }
    }
    values.sort_by(f64::total_cmp);
    values
}

/// One entry per column, by role and name; those that are left come last.
pub(super) fn uses(
    requested: &RequestedRoles,
    labels: &[Label],
    named: &[Named],
    dataset: &Dataset,
) -> Vec<ColumnUse> {
    let one = |Named { column, unit }: &Named| {
        let role = role(column, dataset);
        let reason = match role {
            Some(_) if is_requested(column, requested) => "as requested".to_owned(),
            Some(ColumnRole::Time) if !implies_time(column) => "by what it holds".to_owned(),
            Some(_) => "by its name".to_owned(),
            None => reason_left(column, requested, labels, dataset),
        };
        ColumnUse { column: column.clone(), role, unit: unit.clone(), reason }
    };
    let mut uses: Vec<ColumnUse> = named.iter().map(one).collect();
    // The order of the columns in a file changes nothing.
    uses.sort_by(|a, b| (a.role.is_none(), a.role, &a.column).cmp(&(b.role.is_none(), b.role, &b.column)));
    uses
}

fn implies_time(column: &str) -> bool {
    matches!(meaning(column), Some(Meaning::Time | Meaning::TimeLike))
}

fn role(column: &str, dataset: &Dataset) -> Option<ColumnRole> {
    let roles = &dataset.roles;
    let is = |name: &Option<String>| name.as_deref() == Some(column);
    if let Some(input) = roles.inputs.iter().find(|input| input.column == column) {
        return Some(match input.role {
            Role::Effort => ColumnRole::Effort,
            Role::Motion => ColumnRole::Motion,
            Role::Anchor => ColumnRole::Anchor,
            Role::Given => ColumnRole::Given,
        });
    }
    let others = [
        (&roles.far, ColumnRole::Far),
        (&roles.time, ColumnRole::Time),
        (&roles.trial, ColumnRole::Trial),
        (&roles.group, ColumnRole::Group),
    ];
    others.into_iter().find(|(name, _)| is(name)).map(|(_, role)| role)
}

fn is_requested(column: &str, requested: &RequestedRoles) -> bool {
    let RequestedRoles { far, effort, motion, anchor, given, time, trial, group, .. } = requested;
    let lists = effort.iter().chain(motion).chain(given);
    lists.chain([far, anchor, time, trial, group].into_iter().flatten()).any(|name| name == column)
}

fn reason_left(column: &str, requested: &RequestedRoles, labels: &[Label], dataset: &Dataset) -> String {
    if let Some(label) = labels.iter().find(|label| label.column == column) {
        let values: Vec<String> = label.values.iter().map(ToString::to_string).collect();
        return format!("only the values {}: a label, not a motion", values.join(", "));
    }
    if requested.ignore.iter().any(|name| name == column) {
        return "as requested".to_owned();
    }
    if dataset.conditions.iter().any(|condition| condition.column == column) {
        return "constant within a trial: a condition, not a signal".to_owned();
    }
    let RequestedRoles { effort, motion, anchor, given, .. } = requested;
    let inputs_named = anchor.is_some() || [effort, motion, given].iter().any(|list| !list.is_empty());
    let reason = if inputs_named { "not among the inputs requested" } else { "its name implies no role" };
    reason.to_owned()
}
