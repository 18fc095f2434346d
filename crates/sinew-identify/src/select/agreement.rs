//! Do the logs that are fitted agree with each other, and where one does not, which channel explains it?

use super::candidates::{comparison_recipe, influence_recipe};
use super::hypotheses::{Explanation, explain};
use super::ranges::{Ranges, error_inside};
use crate::conditioning::ConditionedLogs;
use crate::estimation::rmse;
use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::fit::statistics::mean_and_deviation;
use crate::log::{Defect, DefectKind};
use crate::training::fit;
use rayon::prelude::*;
use sinew::predictor::Estimator;

/// Error of one log's model on another, over the standard deviation of its far side, from which the two
/// contradict each other: good logs of one rig that move through different ranges come to half of it.
const CONTRADICTS: f64 = 0.7;

/// How many times larger it is than the errors between halves of the logs: what does not foretell its own log
/// judges no other.
const WORSE: f64 = 3.0;

/// Error of one half of a log by a model of its other half, over the standard deviation of its far side,
/// below which it foretells itself.
const FORETELLS: f64 = 0.5;

/// How many times larger it is than that of the pair that agrees, for the third log to be the odd one.
const ODD: f64 = 2.5;

/// Error on a log, over the standard deviation of its far side, from which an explanation is looked for.
const UNEXPLAINED: f64 = 0.15;

/// The same with the channel corrected, up to which it is one: beyond it the log remains unexplained.
const EXPLAINED: f64 = 0.3;

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

/// Judges two or three logs by how well a model of each predicts the others; a regression on plays and a
/// small hybrid must come to the same verdict.
///
/// ```text
/// d_ij = sqrt(e_ij e_ji),   e_ij = RMSE on log j of a model fitted to log i / standard deviation of the far side of j
/// contradicts:  d_ij > 0.7 and > 3 sqrt(o_i o_j),   o_i = the same of half of log i by a model of its other half < 0.5,
///               for the second model by the better of both
/// odd k:        both pairs with k contradict, and d_ki > 2.5 d_ij of the other two
/// undecidable:  otherwise the pair of the largest d_ij, where it contradicts
/// ```
pub(crate) fn judge(logs: &ConditionedLogs) -> Verdict {
    if !(2..=3).contains(&logs.data.logs.len()) {
        return Verdict::Agree;
    }
    let recipes = [comparison_recipe(logs), influence_recipe(logs)];
    let own = own_errors(&recipes[0], logs);
    let first = judge_by(logs, &recipes[0], &own);
    if first == Verdict::Agree {
        return first;
    }
    // Half a log may be too little for one of the recipes.
    let own: Vec<f64> = own.into_iter().zip(own_errors(&recipes[1], logs)).map(|(a, b)| a.min(b)).collect();
    match (first, judge_by(logs, &recipes[1], &own)) {
        (Verdict::Odd(a, ratio), Verdict::Odd(b, other)) if a == b => Verdict::Odd(a, ratio.min(other)),
        (_, Verdict::Agree) => Verdict::Agree,
        (Verdict::Undecidable(i, j), _) | (_, Verdict::Undecidable(i, j)) => Verdict::Undecidable(i, j),
        (Verdict::Odd(i, _), Verdict::Odd(j, _)) => Verdict::Undecidable(i, j),
        (Verdict::Agree, _) => Verdict::Agree,
    }
}

fn judge_by(logs: &ConditionedLogs, recipe: &Recipe, own: &[f64]) -> Verdict {
    let count = logs.data.logs.len();
    let errors: Vec<Option<Vec<f64>>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let estimator = fit(recipe, &of_log(&logs.runs, i), 0)?;
            let ranges = Ranges::new(&of_log(&logs.runs, i));
            let on =
                |j: usize| relative(error_inside(&estimator, &ranges, &of_log(&logs.runs, j)), &logs.runs, j);
            Some((0..count).map(on).collect())
        })
        .collect();
    let error = |i: usize, j: usize| errors[i].as_ref().map_or(0.0, |of_model| of_model[j]);
    let distance = |i: usize, j: usize| (error(i, j) * error(j, i)).sqrt();
    // A log of which one half does not foretell the other contradicts nothing.
    let foretells = |i: usize| own[i] < FORETELLS;
    let contradicts = |i: usize, j: usize| {
        let least = CONTRADICTS.max(WORSE * (own[i] * own[j]).sqrt());
        foretells(i) && foretells(j) && distance(i, j) > least
    };
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

/// `o_k` of every log.
fn own_errors(recipe: &Recipe, logs: &ConditionedLogs) -> Vec<f64> {
    let count = logs.data.logs.len();
    (0..count).into_par_iter().map(|k| own_error(recipe, &of_log(&logs.runs, k))).collect()
}

/// Error of one half of a log by a model of its other half, over the standard deviation of its far side;
/// infinite where nothing can be fitted.
fn own_error(recipe: &Recipe, runs: &[&Run]) -> f64 {
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
        runs.iter().map(half).filter(|run| run.len() > 1).collect()
    };
    let (one, other) = (halves(true), halves(false));
    let (one, other): (Vec<&Run>, Vec<&Run>) = (one.iter().collect(), other.iter().collect());
    let of = |training: &[&Run], held: &[&Run]| {
        fit(recipe, training, 0).map_or(f64::INFINITY, |estimator| rmse(&estimator, held) / deviation(runs))
    };
    let error = (0.5 * (of(&one, &other).powi(2) + of(&other, &one).powi(2))).sqrt();
    if error.is_finite() { error } else { f64::INFINITY }
}

/// The smaller error, of two kinds of models, of one half of a log by a model of its other half, over its
/// deviation. In a log that hardly moves it is large: what friction holds from before its beginning looks
/// like any fault.
fn min_own_error(logs: &ConditionedLogs, runs: &[&Run]) -> f64 {
    let recipes = [comparison_recipe(logs), influence_recipe(logs)];
    recipes.iter().map(|recipe| own_error(recipe, runs)).fold(f64::INFINITY, f64::min)
}

/// What a wrong channel explains of log `k` by a model of the logs `sound`; `None` where either of two kinds
/// of models predicts it inside of their ranges, where no channel explains it, and where it, corrected, does
/// not foretell itself.
pub(crate) fn explanation(logs: &ConditionedLogs, k: usize, sound: &[usize]) -> Option<Explanation> {
    let training: Vec<&Run> = logs.runs.iter().filter(|run| sound.contains(&run.log)).collect();
    let (runs, ranges) = (of_log(&logs.runs, k), Ranges::new(&training));
    let over_deviation = |error: f64| relative(error, &logs.runs, k);
    let is_predicted =
        |estimator: &Estimator| over_deviation(error_inside(estimator, &ranges, &runs)) < UNEXPLAINED;
    let recipes = [comparison_recipe(logs), influence_recipe(logs)];
    let estimator = fit(&recipes[0], &training, 0)?;
    if is_predicted(&estimator) || fit(&recipes[1], &training, 0).is_none_or(|e| is_predicted(&e)) {
        return None;
    }
    let found = explain(&estimator, &logs.data, &runs, logs.data.logs[k].interval_s)?;
    let own = || {
        let corrected = found.corrected(&runs);
        min_own_error(logs, &corrected.iter().collect::<Vec<_>>())
    };
    let foretells_itself = |own: f64| own < FORETELLS && over_deviation(found.error_before()) > WORSE * own;
    let is_explained =
        found.is_convincing() && over_deviation(found.error_after()) < EXPLAINED && foretells_itself(own());
    is_explained.then_some(found)
}

/// Adds a defect to every log that the others predict badly, and which a gain, offset or shift of one channel
/// explains. The log whose error falls most is named first, and its like only where they remain without it.
pub(crate) fn report_explained(logs: &mut ConditionedLogs) {
    let count = logs.data.logs.len();
    let mut sound: Vec<usize> = (0..count).collect();
    // Of two logs none can be called right.
    while sound.len() > 2 {
        let found: Vec<Option<Explanation>> = sound
            .par_iter()
            .map(|&k| {
                let others: Vec<usize> = sound.iter().copied().filter(|&i| i != k).collect();
                explanation(logs, k, &others)
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
        let explained = explanation(logs, k, &[other]);
        let what =
            explained.map_or_else(String::new, |e| format!(" (either {}, or the reverse there)", e.words()));
        let remedy = if count == 2 { "a third log" } else { "a fourth log" };
        let sentence = format!(
            "contradicts {name}: a model of one does not predict the other{what}; {count} logs cannot say \
                which is wrong, and the model is a mean of both; {remedy} decides, or leave one out"
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
    error / deviation(&of_log(runs, log))
}

/// Standard deviation of the far side; above 0.
fn deviation(runs: &[&Run]) -> f64 {
    let counted = |run: &&Run| -> Vec<f64> {
        run.far.iter().zip(&run.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y).collect()
    };
    let far: Vec<f64> = runs.iter().flat_map(counted).collect();
    mean_and_deviation(&far).1.max(1e-300)
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
                "`{column}` comes {ms:.0} ms {way} than {beside} moves: shifted back, it is predicted with \
                    less than half of the error; two clocks or a filter, and the model takes the delay for \
                    friction"
            );
            info.add(Defect::of_log(DefectKind::Shifted, &column, sentence));
        }
    }
}
