//! The influence check: does a log spoil the prediction of all others?

use super::agreement::{Verdict, explanation, judge, relative, report_contradiction, report_explained};
use super::candidates::influence_recipe;
use crate::Error;
use crate::conditioning::ConditionedLogs;
use crate::estimation::rmse;
use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::log::{Dataset, Role};
use crate::training::fit;
use rayon::prelude::*;
use serde::Serialize;

/// An outlier log raises the others' error by more than exp(0.15), a sixth, and is itself predicted more than
/// e times worse than they are. Neither says enough alone: a log of a new condition is predicted badly and
/// helps; a noisy one harms a little and is predicted as they are.
const MIN_INFLUENCE: f64 = 0.15;
const MIN_DEVIATION: f64 = 1.0;

/// Error on an outlier log, over the standard deviation of its far side, at least: where sensors are good, a
/// log may be predicted many times worse than the others and still well. Good logs came to 0.19, outlier ones
/// to 0.53 and more.
const MIN_RELATIVE: f64 = 0.25;

/// Logs that must remain.
const FEWEST: usize = 3;

/// Logs that are kept although they look like outliers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Keep {
    /// Every log.
    All,
    /// The logs of these names.
    Logs(Vec<String>),
    /// None.
    #[default]
    Judged,
}

/// What tells an outlier log from the others; NaN for a log that is not judged.
#[derive(Debug, Clone, Copy)]
struct Judgement {
    influence: f64,
    deviation: f64,
    /// Error by a model of the others over the standard deviation of its far side.
    relative: f64,
}

impl Default for Judgement {
    fn default() -> Self {
        Self { influence: f64::NAN, deviation: f64::NAN, relative: f64::NAN }
    }
}

impl Judgement {
    fn is_outlier(self) -> bool {
        self.influence > MIN_INFLUENCE && self.deviation > MIN_DEVIATION && self.relative > MIN_RELATIVE
    }
}

/// One row of the influence check.
#[derive(Debug, Clone, Serialize)]
pub struct InfluenceRow {
    /// Log name.
    pub log: String,
    /// Mean over the other logs of ln(error with it in training / error without it).
    pub influence: f64,
    /// ln(its error / geometric mean of the others' errors), each predicted by models fitted to neither.
    pub deviation: f64,
    /// Whether it was left out of the final fit.
    pub dropped: bool,
    /// Why, in words; empty for an ordinary log.
    pub remark: String,
}

/// Excludes outlier logs, the worst first, and reports the influence of every log.
///
/// ```text
/// influence_k = mean over i != k of ln( error on i, fitted to all but i / fitted to all but i and k )
/// deviation_k = mean over i != k of ln( error on k, fitted to all but k / error on i, fitted to all but i and k )
/// ```
///
/// A log that is unlike the others is predicted worse than they are and biases the fit for all of them; a log
/// that merely covers another condition does not: without it the others are predicted no better. A log that
/// alone has its value of a given quantity, such as a sheath's bend, is kept: the recording and the condition
/// cannot be told apart. Of three logs the odd one is left out where the two others agree; otherwise those
/// that contradict each other are reported, as of two.
///
/// # Errors
/// [`Error::UnknownLog`] for a log to keep that is not there.
pub(crate) fn exclude_outlier_logs(
    logs: ConditionedLogs,
    keep_asked: &Keep,
) -> Result<(ConditionedLogs, Vec<InfluenceRow>), Error> {
    let reasons_to_keep = reasons_to_keep(&logs.data, keep_asked)?;
    let recipe = influence_recipe(&logs);
    let count = logs.data.logs.len();
    let mut keep = vec![true; count];
    let mut reported = vec![Judgement::default(); count];
    while keep.iter().filter(|k| **k).count() > FEWEST {
        let values = influences(&logs.runs, &recipe, &keep);
        // An outlier log keeps the value with which it was excluded, the others have that of the last round.
        for k in (0..count).filter(|&k| keep[k]) {
            reported[k] = values[k];
        }
        let excludable = |k: &usize| keep[*k] && reasons_to_keep[*k].is_none() && values[*k].is_outlier();
        let worst = (0..count)
            .filter(excludable)
            .max_by(|&a, &b| values[a].influence.total_cmp(&values[b].influence));
        let Some(outlier) = worst else { break };
        keep[outlier] = false;
    }
    let rows = (0..count).filter(|_| count > FEWEST).map(|k| InfluenceRow {
        log: logs.data.logs[k].name.clone(),
        influence: reported[k].influence,
        deviation: reported[k].deviation,
        dropped: !keep[k],
        remark: match &reasons_to_keep[k] {
            _ if !keep[k] => remark_excluded(reported[k]),
            Some(reason) if reported[k].is_outlier() => remark_kept(reported[k], reason),
            None if reported[k].is_outlier() => remark_kept(reported[k], TOO_FEW_LEFT),
            _ => String::new(),
        },
    });
    let mut rows: Vec<InfluenceRow> = rows.collect();
    let kept: Vec<usize> = (0..count).filter(|&k| keep[k]).collect();
    for (k, row) in rows.iter_mut().enumerate().filter(|(_, row)| row.dropped) {
        explain_row(&logs, k, &kept, row);
    }
    let logs = logs.retain(&keep);
    Ok(settle_three(logs, rows, keep_asked))
}

/// Adds to the remark of a log that was left out its defects, or without any which channel would explain it.
fn explain_row(logs: &ConditionedLogs, k: usize, kept: &[usize], row: &mut InfluenceRow) {
    let defects = &logs.data.logs[k].defects;
    if !defects.is_empty() {
        defects.iter().for_each(|defect| row.remark += &format!(" {}.", defect.sentence));
        return;
    }
    if let Some(explained) = explanation(logs, k, kept) {
        row.remark += &format!(" What explains it best: {}.", explained.words());
    }
}

/// Leaves out the odd one of three logs, and reports those of two or three that contradict each other.
fn settle_three(
    mut logs: ConditionedLogs,
    mut rows: Vec<InfluenceRow>,
    keep_asked: &Keep,
) -> (ConditionedLogs, Vec<InfluenceRow>) {
    // Names of logs that are gone by now were checked before.
    let reasons = |logs: &ConditionedLogs| -> Vec<Option<String>> {
        let present = |name: &String| logs.data.logs.iter().any(|log| log.name == *name);
        let keep = match keep_asked {
            Keep::Logs(names) => Keep::Logs(names.iter().filter(|name| present(name)).cloned().collect()),
            other => other.clone(),
        };
        reasons_to_keep(&logs.data, &keep).unwrap_or_default()
    };
    // Where each log has its own value of a given quantity, their difference is what one expects.
    let alone =
        |logs: &ConditionedLogs, k: usize| givens(&logs.data).any(|given| alone_in(&logs.data, k, given));
    if (0..logs.data.logs.len()).any(|k| alone(&logs, k)) {
        return (logs, rows);
    }
    match judge(&logs) {
        Verdict::Odd(odd, ratio) if reasons(&logs).get(odd).is_some_and(Option::is_none) => {
            let sound: Vec<usize> = (0..3).filter(|&k| k != odd).collect();
            let values = influences(&logs.runs, &influence_recipe(&logs), &[true; 3]);
            let mut new: Vec<InfluenceRow> = (0..3)
                .map(|k| InfluenceRow {
                    log: logs.data.logs[k].name.clone(),
                    influence: values[k].influence,
                    deviation: values[k].deviation,
                    dropped: k == odd,
                    remark: String::new(),
                })
                .collect();
            new[odd].remark = format!(
                "The two other logs predict each other, and it {ratio:.1} times worse: the odd one of three. \
                    It was left out; find out what was different that day, or keep it with --keep."
            );
            explain_row(&logs, odd, &sound, &mut new[odd]);
            if rows.is_empty() {
                rows = new;
            } else if let (Some(row), Some(found)) =
                (rows.iter_mut().find(|row| row.log == new[odd].log), new.get(odd))
            {
                *row = found.clone();
            }
            let keep: Vec<bool> = (0..3).map(|k| k != odd).collect();
            (logs.retain(&keep), rows)
        }
        Verdict::Odd(odd, _) => {
            let other = usize::from(odd == 0);
            report_contradiction(&mut logs, (odd, other));
            (logs, rows)
        }
        Verdict::Undecidable(i, j) => {
            report_contradiction(&mut logs, (i, j));
            (logs, rows)
        }
        Verdict::Agree => {
            report_explained(&mut logs);
            (logs, rows)
        }
    }
}

/// Why a log stays that is like a outlier one.
const TOO_FEW_LEFT: &str = "three logs are left, too few to say which of them is the outlier one";

fn remark_excluded(judged: Judgement) -> String {
    format!(
        "{}: an outlier recording. It was left out; find out what was different that day.",
        described(judged)
    )
}

fn remark_kept(judged: Judgement, reason: &str) -> String {
    format!("{}. It was kept: {reason}.", described(judged))
}

fn described(Judgement { influence, deviation, .. }: Judgement) -> String {
    format!(
        "With it in training the other logs are predicted {:.2} times worse, and it is itself predicted \
            {:.1} times worse than they are (limits {:.2} and {:.1})",
        influence.exp(),
        deviation.exp(),
        MIN_INFLUENCE.exp(),
        MIN_DEVIATION.exp()
    )
}

/// Refuses a log to keep that is not there.
///
/// # Errors
/// [`Error::UnknownLog`].
pub(crate) fn check_keep(data: &Dataset, keep: &Keep) -> Result<(), Error> {
    reasons_to_keep(data, keep).map(|_| ())
}

/// For every log, why it stays whatever its influence.
fn reasons_to_keep(data: &Dataset, keep: &Keep) -> Result<Vec<Option<String>>, Error> {
    let known = || data.logs.iter().map(|log| log.name.clone());
    if let Keep::Logs(names) = keep
        && let Some(name) = names.iter().find(|name| known().all(|log| log != **name))
    {
        return Err(Error::UnknownLog { name: name.clone(), known: known().collect() });
    }
    let asked = |name: &String| match keep {
        Keep::All => true,
        Keep::Logs(names) => names.contains(name),
        Keep::Judged => false,
    };
    let reason = |log: usize| {
        if asked(&data.logs[log].name) {
            return Some("as requested".to_owned());
        }
        let alone = givens(data).find(|given| alone_in(data, log, *given))?;
        let column = &data.roles.inputs[alone].column;
        Some(format!(
            "no other log has its value of `{column}`, so that an outlier recording and another condition look alike"
        ))
    };
    Ok((0..data.logs.len()).map(reason).collect())
}

/// The given inputs.
fn givens(data: &Dataset) -> impl Iterator<Item = usize> + '_ {
    let inputs = data.roles.inputs.iter().enumerate();
    inputs.filter(|(_, input)| input.role == Role::Given).map(|(place, _)| place)
}

/// Whether an input is constant in `log` at a value that no other log comes to.
fn alone_in(data: &Dataset, log: usize, input: usize) -> bool {
    let span = |log: usize| {
        let width = data.roles.inputs.len();
        let values = data.sequences.iter().filter(|s| s.log == log);
        let values =
            values.flat_map(|s| s.inputs.iter().skip(input).step_by(width)).filter(|x| x.is_finite());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
    };
    let (low, high) = span(log);
    let others = (0..data.logs.len()).filter(|other| *other != log).map(span);
    low >= high && others.into_iter().all(|(least, most)| high < least || low > most)
}

/// The influence of every kept log; NaN for the others.
fn influences(runs: &[Run], recipe: &Recipe, keep: &[bool]) -> Vec<Judgement> {
    let present: Vec<usize> = (0..keep.len()).filter(|&k| keep[k]).collect();
    // One fit without {i, k} gives the error on i without k, and on k without i.
    let pairs: Vec<(usize, usize)> = present
        .iter()
        .flat_map(|&i| present.iter().filter(move |&&k| k >= i).map(move |&k| (i, k)))
        .collect();
    let errors: Vec<Option<(f64, f64)>> =
        pairs.par_iter().map(|&pair| errors_without(runs, recipe, keep, pair)).collect();
    let error = |i: usize, k: usize| {
        let pair = (i.min(k), i.max(k));
        let (first, second) = errors[pairs.iter().position(|p| *p == pair)?]?;
        Some(if i <= k { first } else { second })
    };
    (0..keep.len())
        .map(|k| {
            let others = || present.iter().filter(|&&i| keep[k] && i != k);
            Judgement {
                influence: mean(others().filter_map(|&i| Some((error(i, i)? / error(i, k)?).ln()))),
                deviation: mean(others().filter_map(|&i| Some((error(k, k)? / error(i, k)?).ln()))),
                relative: keep[k]
                    .then(|| error(k, k))
                    .flatten()
                    .map_or(f64::NAN, |own| relative(own, runs, k)),
            }
        })
        .collect()
}

/// Mean of the finite numbers, NaN of none.
fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) =
        numbers.filter(|x| x.is_finite()).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    sum / count
}

/// Errors on the logs `i` and `k` of a model fitted to all kept logs but these two.
fn errors_without(
    runs: &[Run],
    recipe: &Recipe,
    keep: &[bool],
    (i, k): (usize, usize),
) -> Option<(f64, f64)> {
    let training: Vec<&Run> = runs.iter().filter(|r| keep[r.log] && r.log != i && r.log != k).collect();
    let estimator = fit(recipe, &training, 0)?;
    let error = |log: usize| {
        let held_out: Vec<&Run> = runs.iter().filter(|run| run.log == log).collect();
        rmse(&estimator, &held_out).max(1e-300)
    };
    Some((error(i), error(k)))
}
