//! Logs with known roles to one dataset: what concerns all logs together.

use super::conditions;
use super::duplicates;
use super::memory_limit::{MEMORY_LIMIT_BYTES, bytes_per_row};
use super::occurrences::counted;
use super::one_log::{ReadLog, read_log};
use super::open::OpenLog;
use super::roles::{Columns, one_column};
use super::signal_checks::check_signals;
use super::types::{Dataset, LogInfo, ReadOptions, Roles, Sequence};
use crate::Error;

/// Reads all logs and puts them together.
pub(super) fn assemble(roles: Roles, logs: Vec<OpenLog>, options: &ReadOptions) -> Result<Dataset, Error> {
    let mut dataset = gather(roles, logs, options)?;
    check_signals(&mut dataset, options.far_required)?;
    Ok(counted_samples(dataset))
}

/// The same of signals that may all be constant: references, not measurements.
pub(super) fn assemble_references(
    roles: Roles,
    logs: Vec<OpenLog>,
    options: &ReadOptions,
) -> Result<Dataset, Error> {
    Ok(counted_samples(gather(roles, logs, options)?))
}

fn gather(roles: Roles, logs: Vec<OpenLog>, options: &ReadOptions) -> Result<Dataset, Error> {
    refuse_large(&roles, &logs)?;
    let far_required = options.far_required;
    let mut read = Vec::with_capacity(logs.len());
    for log in logs {
        read.push(read_log(&roles, log, options)?);
    }
    let mut sequences = Vec::new();
    let mut infos = Vec::new();
    let mut constants = Vec::new();
    for (k, log) in read.into_iter().enumerate() {
        infos.push(info(&log));
        sequences.extend(log.cut.sequences.into_iter().map(|s| Sequence { log: k, ..s }));
        constants.push(log.constants);
    }
    let always: Vec<&str> = roles.group.iter().chain(&options.conditions).map(String::as_str).collect();
    let found = conditions::find(&always, &constants, &mut sequences);
    let mut dataset = Dataset { roles, columns: Vec::new(), logs: infos, conditions: found, sequences };
    if far_required {
        drop_duplicates(&mut dataset);
    }
    Ok(dataset)
}

/// Adds samples and durations to the account of the logs.
fn counted_samples(mut dataset: Dataset) -> Dataset {
    for sequence in &dataset.sequences {
        let info = &mut dataset.logs[sequence.log];
        info.samples += sequence.row.len();
        info.duration_s += duration(sequence);
    }
    dataset
}

fn duration(sequence: &Sequence) -> f64 {
    match (sequence.time_s.first(), sequence.time_s.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    }
}

fn info(log: &ReadLog) -> LogInfo {
    let mut info = LogInfo {
        name: log.file.clone(),
        samples: 0,
        trials: log.cut.trials,
        duration_s: 0.0,
        interval_s: log.cut.interval_s,
        findings: log.cut.findings.clone(),
        defects: Vec::new(),
    };
    log.defects.iter().for_each(|defect| info.add(defect.clone()));
    info
}

/// Refuses logs whose requested columns would not fit into memory.
fn refuse_large(roles: &Roles, logs: &[OpenLog]) -> Result<(), Error> {
    let per_row = bytes_per_row(roles.inputs.len() + 2) as u64;
    let mut bytes = 0_u64;
    for log in logs {
        bytes = bytes.saturating_add(log.rows().saturating_mul(per_row));
        if bytes > MEMORY_LIMIT_BYTES {
            return Err(Error::TooLarge {
                file: log.file.clone(),
                needed_mb: bytes >> 20,
                limit_mb: MEMORY_LIMIT_BYTES >> 20,
            });
        }
    }
    Ok(())
}

/// Drops sequences that an earlier log holds too, and logs that have nothing else.
fn drop_duplicates(dataset: &mut Dataset) {
    let twins = duplicates::find(&dataset.sequences);
    let logs = dataset.logs.len();
    let mut kept = vec![0_usize; logs];
    let mut dropped: Vec<Vec<usize>> = vec![Vec::new(); logs];
    for (sequence, twin) in dataset.sequences.iter().zip(&twins) {
        match twin {
            Some(j) => dropped[sequence.log].push(dataset.sequences[*j].log),
            None => kept[sequence.log] += 1,
        }
    }
    for log in 0..logs {
        let Some(&twin) = dropped[log].first() else { continue };
        let (name, twin_name) = (dataset.logs[log].name.clone(), dataset.logs[twin].name.clone());
        if kept[log] == 0 {
            let finding = format!("{name} holds the same samples and was left out");
            dataset.logs[twin].findings.push(finding);
        } else {
            let count = dropped[log].len();
            let finding = format!("dropped {} that {twin_name} holds too", counted(count, "sequence"));
            dataset.logs[log].findings.push(finding);
        }
    }
    let mut twins = twins.into_iter();
    dataset.sequences.retain(|_| twins.next().flatten().is_none());
    renumber(dataset, &kept, &dropped);
}

/// Removes logs that were left out whole.
fn renumber(dataset: &mut Dataset, kept: &[usize], dropped: &[Vec<usize>]) {
    let mut new_index = Vec::with_capacity(kept.len());
    let mut next = 0;
    for (k, d) in kept.iter().zip(dropped) {
        new_index.push(next);
        next += usize::from(*k > 0 || d.is_empty());
    }
    for sequence in &mut dataset.sequences {
        sequence.log = new_index[sequence.log];
    }
    let mut stays = kept.iter().zip(dropped).map(|(k, d)| *k > 0 || d.is_empty());
    dataset.logs.retain(|_| stays.next().unwrap_or(true));
}

/// Refuses logs that lack what a model needs.
pub(super) fn complete(roles: &Roles, logs: &[Columns<'_>], far_required: bool) -> Result<(), Error> {
    for input in &roles.inputs {
        one_column(&input.column, false, logs)?;
    }
    for (column, optional) in
        [(&roles.time, false), (&roles.far, !far_required), (&roles.trial, true), (&roles.group, true)]
    {
        if let Some(column) = column {
            one_column(column, optional, logs)?;
        }
    }
    Ok(())
}
