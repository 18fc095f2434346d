//! One log: read, scaled to seconds, cut into sequences, checked for spikes.

use super::clock::Clock;
use super::conditions::LogConstants;
use super::cut::{self, CutLog};
use super::occurrences::{Occurrences, counted};
use super::open::OpenLog;
use super::spikes;
use super::table::{ColumnLayout, Requested, Table};
use super::types::{Defect, ReadOptions, Roles, Sequence};
use crate::Error;

/// One log, read and cut.
pub(super) struct ReadLog {
    /// Its name.
    pub(super) file: String,
    /// Its sequences.
    pub(super) cut: CutLog,
    /// What is constant within its trials.
    pub(super) constants: LogConstants,
    /// Defects of its time.
    pub(super) defects: Vec<Defect>,
}

/// Reads one log.
pub(super) fn read_log(roles: &Roles, mut log: OpenLog, options: &ReadOptions) -> Result<ReadLog, Error> {
    let file = log.file.clone();
    let columns = log.names.clone();
    let at = |name: &String| columns.iter().position(|c| c == name);
    let far = roles.far.as_ref().and_then(at);
    let time = roles.time.as_ref().and_then(at);
    let mut numbers: Vec<usize> = roles.inputs.iter().filter_map(|i| at(&i.column)).collect();
    let inputs = numbers.len();
    let mut place = |column: Option<usize>| {
        column.map(|c| {
            numbers.push(c);
            numbers.len() - 1
        })
    };
    let layout = ColumnLayout { inputs, far: place(far), time: place(time) };
    let trial = roles.trial.as_ref().and_then(at);
    let group = roles.group.as_ref().and_then(at);
    // A group may be the trial column itself.
    let candidates = (0..columns.len())
        .filter(|&c| Some(c) != far && Some(c) != time && (Some(c) != trial || trial == group))
        .collect();
    let factors: Vec<f64> = numbers.iter().map(|&c| log.factors[c]).collect();
    let clock = time.map(|c| Clock::from_column(&log, c));
    let requested =
        Requested { numbers, stamped: time.filter(|&c| log.is_stamped(c)), trial, group, candidates };
    let named = std::mem::take(&mut log.findings);
    let mut table = log.read(&requested)?;
    convert(&mut table, &factors);
    group_within_trials(&file, roles, &table)?;
    let mut findings = std::mem::take(&mut table.findings);
    findings.extend(named);
    for (name, lacking) in
        [(&roles.far, far.is_none()), (&roles.trial, trial.is_none()), (&roles.group, group.is_none())]
    {
        if let (Some(name), true) = (name, lacking) {
            findings.push(format!("there is no column `{name}`"));
        }
    }
    let mut defects = Vec::new();
    if let (Some(k), Some(clock)) = (layout.time, &clock) {
        clock.to_seconds(&file, &mut table.numbers[k], &mut findings, &mut defects)?;
    }
    missing_cells(&table, &requested, &columns, layout, &mut findings);
    let mut cut = cut::cut(&file, &table, layout, options)?;
    // Frees the table: a long log is not held twice.
    table.numbers = Vec::new();
    findings.append(&mut cut.findings);
    cut.findings = findings;
    clean(roles, &mut cut);
    let constants = LogConstants {
        columns: table.constants.into_iter().map(|(c, runs)| (columns[c].clone(), runs)).collect(),
        first_rows: cut.first_rows.clone(),
    };
    Ok(ReadLog { file, cut, constants, defects })
}

/// Numbers to the units of the other logs.
fn convert(table: &mut Table, factors: &[f64]) {
    for (numbers, factor) in table.numbers.iter_mut().zip(factors) {
        if factor.to_bits() != 1.0_f64.to_bits() {
            numbers.iter_mut().for_each(|x| *x *= factor);
        }
    }
}

/// Refuses a group that changes within a trial.
fn group_within_trials(file: &str, roles: &Roles, table: &Table) -> Result<(), Error> {
    let (Some(trial), Some(group)) = (&table.trial, &table.group) else { return Ok(()) };
    for &(row, _) in group.starts.iter().skip(1) {
        let starts_trial = trial.starts.binary_search_by_key(&row, |&(start, _)| start).is_ok();
        if !starts_trial {
            return Err(Error::GroupChanges {
                file: file.to_owned(),
                line: table.lines[row],
                column: roles.group.clone().unwrap_or_default(),
                before: group.at(row - 1).to_owned(),
                after: group.at(row).to_owned(),
            });
        }
    }
    Ok(())
}

/// Counts empty cells, column by column; empty cells of time are reported as rows without time.
fn missing_cells(
    table: &Table,
    requested: &Requested,
    columns: &[String],
    layout: ColumnLayout,
    findings: &mut Vec<String>,
) {
    for (k, numbers) in table.numbers.iter().enumerate() {
        let mut occurrences = Occurrences::default();
        for (row, _) in numbers.iter().enumerate().filter(|(_, x)| x.is_nan()) {
            occurrences.record(|| format!("line {}", table.lines[row]));
        }
        if occurrences.count > 0 && layout.time != Some(k) {
            let name = &columns[requested.numbers[k]];
            findings.push(format!(
                "{} without a number in `{name}`: {}",
                counted(occurrences.count, "cell"),
                occurrences.places()
            ));
        }
    }
}

/// Finds spikes on both sides and sets the far side to fit.
///
/// A spike of the far side is not a measurement to score against; one of the near side reaches the predictor
/// at run time too, and stays.
fn clean(roles: &Roles, cut: &mut CutLog) {
    let far: Vec<Vec<f64>> = cut.sequences.iter().map(|s| s.far.clone()).collect();
    let found = spikes::find(&far);
    for (sequence, far) in cut.sequences.iter_mut().zip(far) {
        sequence.far_clean = if found.is_empty() { far } else { spikes::median5(&far) };
    }
    for &(s, i) in &found {
        cut.sequences[s].scored[i] = false;
    }
    if let (Some(name), false) = (&roles.far, found.is_empty()) {
        let places = spike_places(cut, &found);
        cut.findings.push(format!(
            "{} of `{name}`, which are not scored, and the signal is fitted after a median of 5: {places}",
            counted(found.len(), "spike")
        ));
    }
    let inputs = roles.inputs.len();
    for (k, input) in roles.inputs.iter().enumerate() {
        let column = |s: &Sequence| s.inputs.iter().skip(k).step_by(inputs).copied().collect();
        let found = spikes::find(&cut.sequences.iter().map(column).collect::<Vec<_>>());
        if !found.is_empty() {
            let places = spike_places(cut, &found);
            let name = &input.column;
            cut.findings.push(format!("{} of `{name}`, left in: {places}", counted(found.len(), "spike")));
        }
    }
}

fn spike_places(cut: &CutLog, found: &[(usize, usize)]) -> String {
    let mut occurrences = Occurrences::default();
    for &(s, i) in found {
        let sequence = &cut.sequences[s];
        occurrences.record(|| format!("{:.3} s (line {})", sequence.time_s[i], sequence.row[i]));
    }
    occurrences.places()
}
