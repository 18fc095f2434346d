//! The influence check: does a log spoil the prediction of all others?

use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::log::Dataset;
use crate::report::InfluenceRow;
use crate::training::{fit, rmse};
use rayon::prelude::*;

/// A log that raises the others' error by more than exp(0.4), one and a half times, is foreign. On real recordings a
/// foreign one had 0.5 to 0.9 and ordinary ones at most 0.37, the most where few logs were left.
const LIMIT: f64 = 0.4;

/// Logs that must remain.
const FEWEST: usize = 3;

/// Leaves out foreign logs, the worst first, and says why; `keep[log]`.
///
/// ```text
/// influence_k = mean over i != k of ln( error on i, fitted to all but i / fitted to all but i and k )
/// ```
///
/// A log that is unlike the others pulls the fit away from all of them; a log that merely covers another
/// condition does not, for without it the others are predicted no better.
pub(crate) fn check(data: &Dataset, runs: &[Run], recipe: &Recipe) -> (Vec<bool>, Vec<InfluenceRow>) {
    let logs = data.logs.len();
    let mut keep = vec![true; logs];
    let mut first_values: Option<Vec<f64>> = None;
    let mut remarks = vec![String::new(); logs];
    while keep.iter().filter(|k| **k).count() > FEWEST {
        let values = influences(runs, recipe, &keep);
        let worst = (0..logs).filter(|&k| keep[k]).max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let foreign = worst.filter(|&k| values[k] > LIMIT);
        if let Some(k) = foreign {
            keep[k] = false;
            remarks[k] = format!(
                "With it in training the other logs are predicted {:.1} times worse: a foreign recording. \
                 It was left out; look at what was different that day.",
                values[k].exp()
            );
        }
        let first = first_values.get_or_insert_with(|| values.clone());
        if let Some(k) = foreign {
            first[k] = values[k];
        } else {
            for k in 0..logs {
                if keep[k] {
                    first[k] = values[k];
                }
            }
            break;
        }
    }
    let rows = first_values.map_or_else(Vec::new, |values| {
        (0..logs)
            .map(|k| InfluenceRow {
                log: data.logs[k].name.clone(),
                influence: values[k],
                dropped: !keep[k],
                remark: remarks[k].clone(),
            })
            .collect()
    });
    (keep, rows)
}

fn influences(runs: &[Run], recipe: &Recipe, keep: &[bool]) -> Vec<f64> {
    let present: Vec<usize> = (0..keep.len()).filter(|&k| keep[k]).collect();
    // Fitted without {i, k} once for both: error on i without k, and on k without i.
    let pairs: Vec<(usize, usize)> = present
        .iter()
        .flat_map(|&i| present.iter().filter(move |&&k| k >= i).map(move |&k| (i, k)))
        .collect();
    let errors: Vec<Option<(f64, f64)>> = pairs
        .par_iter()
        .map(|&(i, k)| {
            let kept = |r: &&Run| keep[r.log] && r.log != i && r.log != k;
            let training: Vec<&Run> = runs.iter().filter(kept).collect();
            let member = fit(recipe, &training, 0)?;
            let error = |log: usize| {
                let held: Vec<&Run> = runs.iter().filter(|r| r.log == log).collect();
                rmse(&member, &held).max(1e-300)
            };
            Some((error(i), error(k)))
        })
        .collect();
    let find = |i: usize, k: usize| {
        let pair = (i.min(k), i.max(k));
        let (first, second) = errors[pairs.iter().position(|p| *p == pair)?]?;
        Some(if i <= k { first } else { second })
    };
    (0..keep.len())
        .map(|k| {
            let ratios: Vec<f64> = present
                .iter()
                .filter(|&&i| keep[k] && i != k)
                .filter_map(|&i| Some((find(i, i)? / find(i, k)?).ln()))
                .filter(|r| r.is_finite())
                .collect();
            if ratios.is_empty() { f64::NAN } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
        })
        .collect()
}
