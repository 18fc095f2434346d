//! Signals that identify nothing: refused, or reported where something is left.

use super::durations::report_durations;
use super::likeness::report_likeness;
use super::plateaus::report_plateaus;
use super::types::{Dataset, Role, Sequence};
use crate::Error;

/// Fewest samples with a far side that a model is fitted to.
pub const MIN_SCORED: usize = 20;

/// The name of all logs together in a message.
fn place(dataset: &Dataset) -> String {
    match dataset.logs.as_slice() {
        [only] => only.name.clone(),
        logs => format!("the {} logs together", logs.len()),
    }
}

/// Refuses data without enough samples or without a signal that changes, and reports constant signals.
pub(super) fn check_signals(dataset: &mut Dataset, far_required: bool) -> Result<(), Error> {
    let place = place(dataset);
    let samples: usize = dataset.sequences.iter().map(|s| s.row.len()).sum();
    let needed = if far_required { MIN_SCORED } else { 2 };
    if samples < needed {
        return Err(Error::TooFew { place, what: "samples", expected: needed, got: samples });
    }
    if far_required {
        check_far(dataset, &place)?;
    }
    check_inputs(dataset, &place)?;
    report_plateaus(dataset);
    if far_required {
        report_durations(dataset);
        report_likeness(dataset);
    }
    Ok(())
}

fn check_far(dataset: &Dataset, place: &str) -> Result<(), Error> {
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

fn check_inputs(dataset: &mut Dataset, place: &str) -> Result<(), Error> {
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

/// Whether there are so many samples that all inputs at rest cannot be a short prediction.
fn samples_enough(dataset: &Dataset) -> bool {
    dataset.sequences.iter().map(|s| s.row.len()).sum::<usize>() >= MIN_SCORED
}
