//! Logs with known roles to one dataset: what concerns all logs together.

use super::conditions::{self, LogConstants};
use super::cut::{self, CutLog, Layout, Noted};
use super::find::{Columns, one_column};
use super::open::{MEMORY_LIMIT_BYTES, OpenLog};
use super::table::{Table, Wanted};
use super::types::{Dataset, LogInfo, Role, Roles, Sequence};
use super::{duplicates, names, read::MIN_SCORED, spikes};
use crate::Error;

/// One log, read and cut.
struct ReadLog {
    file: String,
    cut: CutLog,
    constants: LogConstants,
}

/// Reads all logs and puts them together.
pub(super) fn assemble(
    roles: Roles,
    logs: Vec<OpenLog>,
    skip_s: f64,
    far_required: bool,
) -> Result<Dataset, Error> {
    refuse_large(&roles, &logs)?;
    let mut read = Vec::with_capacity(logs.len());
    for log in logs {
        read.push(read_log(&roles, log, skip_s)?);
    }
    let mut sequences = Vec::new();
    let mut infos = Vec::new();
    let mut constants = Vec::new();
    for (k, log) in read.into_iter().enumerate() {
        infos.push(info(&log));
        sequences.extend(log.cut.sequences.into_iter().map(|s| Sequence { log: k, ..s }));
        constants.push(log.constants);
    }
    let found = conditions::find(roles.group.as_deref(), &constants, &mut sequences);
    let mut dataset = Dataset { roles, logs: infos, conditions: found, sequences };
    drop_duplicates(&mut dataset);
    judge_signals(&mut dataset, far_required)?;
    for sequence in &dataset.sequences {
        let info = &mut dataset.logs[sequence.log];
        info.samples += sequence.row.len();
        info.duration_s += duration(sequence);
    }
    Ok(dataset)
}

fn duration(sequence: &Sequence) -> f64 {
    match (sequence.time_s.first(), sequence.time_s.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    }
}

fn info(log: &ReadLog) -> LogInfo {
    LogInfo {
        name: log.file.clone(),
        samples: 0,
        trials: log.cut.trials,
        duration_s: 0.0,
        interval_s: log.cut.interval_s,
        findings: log.cut.findings.clone(),
    }
}

/// Refuses logs whose wanted columns would not fit into memory.
fn refuse_large(roles: &Roles, logs: &[OpenLog]) -> Result<(), Error> {
    let columns = roles.inputs.len() as u64 + 4;
    let mut bytes = 0_u64;
    for log in logs {
        bytes = bytes.saturating_add(log.rows().saturating_mul(columns * 8));
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

fn read_log(roles: &Roles, log: OpenLog, skip_s: f64) -> Result<ReadLog, Error> {
    let file = log.file.clone();
    let columns = log.columns().to_vec();
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
    let layout = Layout { inputs, far: place(far), time: place(time) };
    let trial = roles.trial.as_ref().and_then(at);
    let group = roles.group.as_ref().and_then(at);
    let candidates =
        (0..columns.len()).filter(|&c| Some(c) != far && Some(c) != time && Some(c) != trial).collect();
    let wanted = Wanted { numbers, trial, group, candidates };
    let scale = time.map_or(1.0, |c| names::time_scale(&columns[c], log.unit(c)));
    let mut table = log.read(&wanted)?;
    group_within_trials(&file, roles, &table)?;
    let mut findings = std::mem::take(&mut table.findings);
    for (name, lacking) in
        [(&roles.far, far.is_none()), (&roles.trial, trial.is_none()), (&roles.group, group.is_none())]
    {
        if let (Some(name), true) = (name, lacking) {
            findings.push(format!("there is no column `{name}`"));
        }
    }
    rescale(&mut table, layout, scale, &mut findings);
    missing_cells(&table, &wanted, &columns, layout, &mut findings);
    let mut cut = cut::cut(&file, &table, layout, skip_s)?;
    findings.append(&mut cut.findings);
    cut.findings = findings;
    clean(roles, &mut cut);
    let constants = LogConstants {
        columns: table.constants.into_iter().map(|(c, runs)| (columns[c].clone(), runs)).collect(),
        first_rows: cut.first_rows.clone(),
    };
    Ok(ReadLog { file, cut, constants })
}

/// Time to seconds.
#[expect(clippy::float_cmp, reason = "1.0 is the literal of a table of units, not a result")]
fn rescale(table: &mut Table, layout: Layout, scale: f64, findings: &mut Vec<String>) {
    if let Some(k) = layout.time.filter(|_| scale != 1.0) {
        table.numbers[k].iter_mut().for_each(|t| *t *= scale);
        findings.push(format!("time was multiplied by {scale} to have seconds"));
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

/// Counts empty cells, column by column; those of time are rows without time, told elsewhere.
fn missing_cells(
    table: &Table,
    wanted: &Wanted,
    columns: &[String],
    layout: Layout,
    findings: &mut Vec<String>,
) {
    for (k, numbers) in table.numbers.iter().enumerate() {
        let mut noted = Noted::default();
        for (row, _) in numbers.iter().enumerate().filter(|(_, x)| x.is_nan()) {
            noted.note(|| format!("line {}", table.lines[row]));
        }
        if noted.count > 0 && layout.time != Some(k) {
            let name = &columns[wanted.numbers[k]];
            findings.push(format!("{} cells of `{name}` are empty: {}", noted.count, noted.places()));
        }
    }
}

/// Finds spikes on both sides and sets the far side to fit.
///
/// A spike of the far side is no truth to be scored against; one of the near side is what the predictor
/// will have to live with, and stays.
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
            "{} spikes of `{name}`, which are not scored, and the signal is fitted after a median of 5: {places}",
            found.len()
        ));
    }
    let inputs = roles.inputs.len();
    for (k, input) in roles.inputs.iter().enumerate() {
        let column = |s: &Sequence| s.inputs.iter().skip(k).step_by(inputs).copied().collect();
        let found = spikes::find(&cut.sequences.iter().map(column).collect::<Vec<_>>());
        if !found.is_empty() {
            let places = spike_places(cut, &found);
            let name = &input.column;
            cut.findings.push(format!("{} spikes of `{name}`, left as they are: {places}", found.len()));
        }
    }
}

fn spike_places(cut: &CutLog, found: &[(usize, usize)]) -> String {
    let mut noted = Noted::default();
    for &(s, i) in found {
        let sequence = &cut.sequences[s];
        noted.note(|| format!("{:.3} s (line {})", sequence.time_s[i], sequence.row[i]));
    }
    noted.places()
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
            let finding = format!("{count} sequences are also in {twin_name} and were dropped");
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

/// Where all logs together are meant in a message.
fn place(dataset: &Dataset) -> String {
    match dataset.logs.as_slice() {
        [only] => only.name.clone(),
        logs => format!("the {} logs together", logs.len()),
    }
}

/// Refuses signals from which nothing can be learned, and reports weak ones.
fn judge_signals(dataset: &mut Dataset, far_required: bool) -> Result<(), Error> {
    let place = place(dataset);
    let samples: usize = dataset.sequences.iter().map(|s| s.row.len()).sum();
    let needed = if far_required { MIN_SCORED } else { 2 };
    if samples < needed {
        return Err(Error::TooFew { place, what: "samples", expected: needed, got: samples });
    }
    if far_required {
        judge_far(dataset, &place)?;
    }
    judge_inputs(dataset, &place)
}

fn judge_far(dataset: &Dataset, place: &str) -> Result<(), Error> {
    let place = place.to_owned();
    let far = || dataset.sequences.iter().flat_map(|s| s.far.iter().copied());
    let column = dataset.roles.far.clone().unwrap_or_default();
    match span(far()) {
        None => return Err(Error::AllMissing { place, column }),
        Some((low, high)) if low >= high => {
            let what = "the far signal";
            return Err(Error::Constant { place, what, columns: vec![column], value: low });
        }
        Some(_) => {}
    }
    let scored = dataset.sequences.iter().flat_map(|s| &s.scored).filter(|s| **s).count();
    if scored < MIN_SCORED {
        let what = "samples that can be scored (with a far side, after the skipped seconds)";
        return Err(Error::TooFew { place, what, expected: MIN_SCORED, got: scored });
    }
    Ok(())
}

/// Smallest and largest number, if there is any.
fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|x| !x.is_nan())
        .fold(None, |span, x| Some(span.map_or((x, x), |(low, high): (f64, f64)| (low.min(x), high.max(x)))))
}

fn judge_inputs(dataset: &mut Dataset, place: &str) -> Result<(), Error> {
    let inputs = dataset.roles.inputs.clone();
    let n = inputs.len();
    let mut constant = Vec::new();
    for (k, input) in inputs.iter().enumerate() {
        let column = input.column.clone();
        let of = |s: &Sequence| span(s.inputs.iter().skip(k).step_by(n).copied());
        let mut per_log: Vec<Option<(f64, f64)>> = vec![None; dataset.logs.len()];
        for sequence in &dataset.sequences {
            let ends = [of(sequence), per_log[sequence.log]];
            per_log[sequence.log] = span(ends.into_iter().flatten().flat_map(|(a, b)| [a, b]));
        }
        let Some((low, high)) = span(per_log.iter().flatten().flat_map(|&(a, b)| [a, b])) else {
            return Err(Error::AllMissing { place: place.to_owned(), column });
        };
        if low >= high {
            constant.push((column.clone(), low));
        }
        for (info, span) in dataset.logs.iter_mut().zip(per_log) {
            match span {
                None => info.findings.push(format!("`{column}` holds no number in this log")),
                // A given quantity that is constant within a log is what one expects.
                Some((a, b)) if a >= b && (input.role != Role::Given || low >= high) => {
                    let only = if low >= high { "everywhere" } else { "in this log" };
                    info.findings.push(format!("`{column}` is constant at {a} {only}"));
                }
                Some(_) => {}
            }
        }
    }
    match constant.first() {
        Some(&(_, value)) if constant.len() == n && samples_enough(dataset) => Err(Error::Constant {
            place: place.to_owned(),
            what: "every near-side signal",
            columns: constant.into_iter().map(|(column, _)| column).collect(),
            value,
        }),
        _ => Ok(()),
    }
}

/// A handful of samples to predict may well be at rest.
fn samples_enough(dataset: &Dataset) -> bool {
    dataset.sequences.iter().map(|s| s.row.len()).sum::<usize>() >= MIN_SCORED
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
