//! Do the logs that are fitted agree with each other, and where one does not, which channel explains it?

use super::candidates::{comparison_recipe, influence_recipe};
use super::hypotheses::{Explanation, explain};
use crate::conditioning::ConditionedLogs;
use crate::estimation::rmse;
use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::fit::statistics::{mean_and_deviation, quantiles};
use crate::log::{Defect, DefectKind};
use crate::training::fit;
use rayon::prelude::*;
use sinew::predictor::Estimator;

/// Error of one log's model on another, over the standard deviation of its far side, from which the two contradict each
/// other: good logs of one rig that move through different ranges come to half of it.
const CONTRADICTS: f64 = 0.7;

/// How many times larger it is than the errors between halves of the logs: what does not foretell its own log judges no
/// other.
const WORSE: f64 = 3.0;

/// Share of the samples of a log inside the ranges of another, from which only these are compared.
const OVERLAP: f64 = 0.2;

/// How many times larger it is than that of the pair that agrees, for the third log to be the odd one.
const ODD: f64 = 2.5;

/// Error on a log, over the standard deviation of its far side, from which an explanation is looked for.
const UNEXPLAINED: f64 = 0.15;

/// The logs of a set of two or three, judged by their pairs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Verdict {
    /// No pair contradicts each other.
    Agree,
    /// Two agree, and both contradict this one; how many times worse.
    Odd(usize, f64),
    /// Two contradict each other, and nothing says which is right.
    Undecidable(usize, usize),
}

/// Judges two or three logs by how well a model of each predicts the others; a regression on plays and a small hybrid must
/// come to the same verdict.
///
/// ```text
/// d_ij = sqrt(e_ij e_ji),   e_ij = RMSE on log j of a model fitted to log i / standard deviation of the far side of j
/// contradicts:  d_ij > 0.7 and > 3 sqrt(o_i o_j),   o_i = the same of half of log i by a model of its other half
/// odd k:        both pairs with k contradict, and d_ki > 2.5 d_ij of the other two
/// undecidable:  otherwise the pair of the largest d_ij, where it contradicts
/// ```
pub(crate) fn judge(logs: &ConditionedLogs) -> Verdict {
    if !(2..=3).contains(&logs.data.logs.len()) {
        return Verdict::Agree;
    }
    let first = judge_by(logs, &comparison_recipe(logs));
    if first == Verdict::Agree {
        return first;
    }
    match (first, judge_by(logs, &influence_recipe(logs))) {
        (Verdict::Odd(a, ratio), Verdict::Odd(b, other)) if a == b => Verdict::Odd(a, ratio.min(other)),
        (_, Verdict::Agree) => Verdict::Agree,
        (Verdict::Undecidable(i, j), _) | (_, Verdict::Undecidable(i, j)) => Verdict::Undecidable(i, j),
        (Verdict::Odd(i, _), Verdict::Odd(j, _)) => Verdict::Undecidable(i, j),
        (Verdict::Agree, _) => Verdict::Agree,
    }
}

fn judge_by(logs: &ConditionedLogs, recipe: &Recipe) -> Verdict {
    let count = logs.data.logs.len();
    let errors: Vec<Option<Vec<f64>>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let estimator = fit(recipe, &of_log(&logs.runs, i), 0)?;
            let limits = limits(&logs.runs, i);
            let on = |j: usize| {
                let inside = inside(&of_log(&logs.runs, j), &limits);
                let inside: Vec<&Run> = inside.iter().collect();
                relative(rmse(&estimator, &inside), &logs.runs, j)
            };
            Some((0..count).map(on).collect())
        })
        .collect();
    let own: Vec<f64> = (0..count).into_par_iter().map(|k| own_error(logs, recipe, k)).collect();
    let error = |i: usize, j: usize| errors[i].as_ref().map_or(0.0, |of_model| of_model[j]);
    let distance = |i: usize, j: usize| (error(i, j) * error(j, i)).sqrt();
    let contradicts = |i: usize, j: usize| distance(i, j) > CONTRADICTS.max(WORSE * (own[i] * own[j]).sqrt());
    let pairs: &[(usize, usize)] = if count == 2 { &[(0, 1)] } else { &[(0, 1), (0, 2), (1, 2)] };
    for odd in (0..count).filter(|_| count == 3) {
        let (i, j) = ((odd + 1) % 3, (odd + 2) % 3);
        let (near, far) = (distance(i, j), distance(odd, i).min(distance(odd, j)));
        if contradicts(odd, i) && contradicts(odd, j) && !contradicts(i, j) && far > ODD * near {
            return Verdict::Odd(odd, far / near.max(1e-300));
        }
    }
    let worst = pairs.iter().max_by(|a, b| distance(a.0, a.1).total_cmp(&distance(b.0, b.1)));
    match worst.filter(|(i, j)| contradicts(*i, *j)) {
        Some(&(i, j)) => Verdict::Undecidable(i, j),
        None => Verdict::Agree,
    }
}

/// Error of one half of a log by a model of its other half, over the standard deviation of its far side; infinite where
/// nothing can be fitted.
fn own_error(logs: &ConditionedLogs, recipe: &Recipe, k: usize) -> f64 {
    let halves = |first: bool| -> Vec<Run> {
        let half = |run: &&Run| {
            let n = run.len();
            let rows = if first { 0..n / 2 } else { n / 2..n };
            Run {
                log: run.log,
                dt_s: run.dt_s[rows.clone()].to_vec(),
                inputs: run.inputs[rows.start * run.width..rows.end * run.width].to_vec(),
                far: run.far[rows.clone()].to_vec(),
                weight: run.weight[rows].to_vec(),
                width: run.width,
            }
        };
        of_log(&logs.runs, k).iter().map(half).filter(|run| run.len() > 1).collect()
    };
    let (one, other) = (halves(true), halves(false));
    let (one, other): (Vec<&Run>, Vec<&Run>) = (one.iter().collect(), other.iter().collect());
    let of = |training: &[&Run], held: &[&Run]| {
        fit(recipe, training, 0)
            .map_or(f64::INFINITY, |estimator| relative(rmse(&estimator, held), &logs.runs, k))
    };
    let error = (0.5 * (of(&one, &other).powi(2) + of(&other, &one).powi(2))).sqrt();
    if error.is_finite() { error } else { f64::INFINITY }
}

/// The ranges of the inputs in a log, between their 1 % and 99 % quantiles.
fn limits(runs: &[Run], log: usize) -> Vec<(f64, f64)> {
    let runs = of_log(runs, log);
    let width = runs.first().map_or(0, |run| run.width);
    (0..width)
        .map(|k| {
            let column = runs.iter().flat_map(|run| run.inputs.iter().skip(k).step_by(width).copied());
            let edge = quantiles(column.collect(), &[0.01, 0.99]);
            (edge[0], edge[1])
        })
        .collect()
}

/// Runs in which only the samples inside the ranges of another log count: beyond them its model extrapolates. Where these
/// are few, the ranges themselves contradict each other, and all count.
fn inside(runs: &[&Run], limits: &[(f64, f64)]) -> Vec<Run> {
    let fits =
        |run: &Run, i: usize| run.row(i).iter().zip(limits).all(|(u, (low, high))| (low..=high).contains(&u));
    let masked: Vec<Run> = runs
        .iter()
        .map(|run| {
            let weight = (0..run.len()).map(|i| if fits(run, i) { run.weight[i] } else { 0.0 }).collect();
            Run { weight, ..Run::clone(run) }
        })
        .collect();
    let sum = |weight: &[f64]| weight.iter().sum::<f64>();
    let all: f64 = runs.iter().map(|run| sum(&run.weight)).sum();
    let kept: f64 = masked.iter().map(|run| sum(&run.weight)).sum();
    if kept < OVERLAP * all { runs.iter().copied().cloned().collect() } else { masked }
}

/// What a wrong channel would explain of log `k`, by a model of the logs `sound`; `None` where that predicts it.
pub(crate) fn explanation(logs: &ConditionedLogs, k: usize, sound: &[usize]) -> Option<Explanation> {
    let training: Vec<&Run> = logs.runs.iter().filter(|run| sound.contains(&run.log)).collect();
    let is_predicted = |estimator: &Estimator| {
        relative(rmse(estimator, &of_log(&logs.runs, k)), &logs.runs, k) < UNEXPLAINED
    };
    let estimator = fit(&comparison_recipe(logs), &training, 0)?;
    // Where either of two kinds of models predicts the log, nothing is wrong with it.
    if is_predicted(&estimator) || fit(&influence_recipe(logs), &training, 0).is_none_or(|e| is_predicted(&e))
    {
        return None;
    }
    explain(&estimator, &logs.data, &of_log(&logs.runs, k), logs.data.logs[k].interval_s)
}

/// Adds a defect to every log that the others predict badly, and which a gain, offset or shift of one channel explains.
/// The log whose error falls most is named first, and its like only where they remain without it.
pub(crate) fn report_explained(logs: &mut ConditionedLogs) {
    let count = logs.data.logs.len();
    let mut sound: Vec<usize> = (0..count).collect();
    // Of two logs none can be called right.
    while sound.len() > 2 {
        let found: Vec<Option<Explanation>> = sound
            .par_iter()
            .map(|&k| {
                let others: Vec<usize> = sound.iter().copied().filter(|&i| i != k).collect();
                explanation(logs, k, &others).filter(Explanation::is_convincing)
            })
            .collect();
        let best = found
            .into_iter()
            .zip(&sound)
            .filter_map(|(explanation, &k)| explanation.map(|e| (k, e)))
            .max_by(|(_, a), (_, b)| a.improvement().total_cmp(&b.improvement()));
        let Some((k, explanation)) = best else { return };
        logs.data.logs[k].add(explanation.defect());
        sound.retain(|&i| i != k);
    }
}

/// The two logs that contradict each other, as a defect of each.
pub(crate) fn report_contradiction(logs: &mut ConditionedLogs, (i, j): (usize, usize)) {
    let count = logs.data.logs.len();
    for (k, other) in [(i, j), (j, i)] {
        let name = logs.data.logs[other].name.clone();
        let explained = explanation(logs, k, &[other]).filter(Explanation::is_convincing);
        let what =
            explained.map_or_else(String::new, |e| format!(" (either {}, or the reverse there)", e.words()));
        let remedy = if count == 2 { "a third log" } else { "a fourth log" };
        let sentence = format!(
            "contradicts {name}: a model of one does not predict the other{what}; {count} logs cannot say which is wrong, and the \
             model is a mean of both; {remedy} decides, or leave one out"
        );
        logs.data.logs[k].add(Defect::of_log(DefectKind::Contradiction, "", sentence));
    }
}

/// The runs of one log.
fn of_log(runs: &[Run], log: usize) -> Vec<&Run> {
    runs.iter().filter(|run| run.log == log).collect()
}

/// An error over the standard deviation of the far side of a log.
pub(super) fn relative(error: f64, runs: &[Run], log: usize) -> f64 {
    let counted = |run: &Run| -> Vec<f64> {
        run.far.iter().zip(&run.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y).collect()
    };
    let far: Vec<f64> = of_log(runs, log).into_iter().flat_map(counted).collect();
    error / mean_and_deviation(&far).1.max(1e-300)
}

/// Delay of a channel in all logs that leaves less than half of the error, as a defect of every log.
pub(crate) fn report_shift(logs: &mut ConditionedLogs) {
    let recipe = comparison_recipe(logs);
    let interval = logs.interval_s();
    if let Some(found) = super::hypotheses::common_shift(&recipe, logs) {
        let (column, samples) = found;
        let far = logs.data.roles.far.clone().unwrap_or_default();
        let (way, ms) =
            (if samples > 0 { "later" } else { "earlier" }, 1e3 * interval * samples.unsigned_abs() as f64);
        let beside = if column == far { "the near side".to_owned() } else { format!("`{far}`") };
        for info in &mut logs.data.logs {
            let sentence = format!(
                "`{column}` comes {ms:.0} ms {way} than {beside} moves: shifted back, it is predicted with less than half of the \
                 error; two clocks or a filter, and the model takes the delay for friction"
            );
            info.add(Defect::of_log(DefectKind::Shifted, &column, sentence));
        }
    }
}
